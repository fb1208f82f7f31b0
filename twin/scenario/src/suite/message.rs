//! What is wrong with a flight, in words that lead to the evidence.

use super::{CaseResult, Outcome};

impl CaseResult {
    /// What is wrong, a line each, the first line first to read; empty if nothing is.
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

    /// The command that flies this case again.
    fn again(&self) -> String {
        let set = self.case.overrides.iter().map(|text| format!(" --set {text}"));
        format!("again: twin fly {}{}", self.case.file.display(), set.collect::<String>())
    }
}
