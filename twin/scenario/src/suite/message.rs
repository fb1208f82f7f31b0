//! The message on a failed flight, which leads to its evidence.

use super::{CaseResult, Outcome};

impl CaseResult {
    /// The reasons of a failure, one a line, the most important first; empty if the case passed.
    pub fn message(&self) -> String {
        let mut lines: Vec<String> = match &self.outcome {
            Outcome::NotRun => Vec::new(),
            Outcome::Unusable(why) => vec![why.clone()],
            Outcome::Flown(report) if report.passed => Vec::new(),
            Outcome::Flown(report) if report.broken.is_empty() => {
                vec!["declared to fail in expect.fails, but nothing is broken".to_owned()]
            }
            Outcome::Flown(report) => report.broken.iter().map(ToString::to_string).collect(),
        };
        if !lines.is_empty() && self.case.sample.is_some() {
            lines.push(self.again());
        }
        lines.extend(self.artifact.as_ref().map(|path| format!("recording: {}", path.display())));
        lines.extend(self.replay.as_ref().map(|(path, opens_at_s)| {
            format!("replay: {} opens at {opens_at_s:.2} s", path.display())
        }));
        lines.extend(self.artifact_trouble.as_ref().map(|why| format!("evidence missing: {why}")));
        lines.join("\n")
    }

    /// The command that repeats the flight of this case.
    fn again(&self) -> String {
        let set = self.case.overrides.iter().map(|text| format!(" --set {text}"));
        format!("again: twin fly {}{}", self.case.file.display(), set.collect::<String>())
    }
}
