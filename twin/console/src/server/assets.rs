//! The console as the build script packed it; empty if this build has none.

include!(concat!(env!("OUT_DIR"), "/assets.rs"));
