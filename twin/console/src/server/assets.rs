//! The files of the console, which the build script packed. The table is empty if this build has no console.

include!(concat!(env!("OUT_DIR"), "/assets.rs"));
