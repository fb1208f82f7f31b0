//! A scenario written into another folder: the paths in it still name the same files.

use std::io;
use std::path::{Path, absolute};

use super::Scenario;

/// The word of `predictor.weights` that is no path.
const BUILT_IN: &str = "default";

impl Scenario {
    /// This scenario for a file in `folder`. In the folder of its own file the paths stay; in any other they become absolute.
    ///
    /// # Errors
    /// If the folder of the process is gone, so that no path is absolute.
    pub fn for_folder(&self, folder: &Path) -> io::Result<Self> {
        let here = |folder: &Path| {
            absolute(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })
        };
        let own = here(self.folder())?;
        let mut moved = self.clone();
        if here(folder)? == own {
            return Ok(moved);
        }
        let settings = &mut moved.settings;
        let place = |path: &mut String| *path = own.join(&*path).display().to_string();
        place(&mut settings.vehicle.urdf);
        settings.arena.objects.iter_mut().for_each(|object| place(&mut object.urdf));
        for pair in &mut settings.vehicle.packages {
            if let Some((name, path)) = pair.split_once('=') {
                *pair = format!("{name}={}", own.join(path).display());
            }
        }
        if settings.predictor.weights != BUILT_IN {
            place(&mut settings.predictor.weights);
        }
        Ok(moved)
    }
}
