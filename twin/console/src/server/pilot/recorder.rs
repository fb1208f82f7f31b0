//! Records the flight: begins and ends its file, and tells what happened to it.

use super::Pilot;
use crate::server::ServerError;
use crate::server::flight_recorder::News;
use crate::server::protocol::NoticeLevel;
use twin_input::interruption;
use twin_record::RecordingEnd;
use twin_scenario::Verdict;

impl Pilot {
    pub(super) fn begin_recording(&mut self) -> Result<(), ServerError> {
        if self.flight_recorder.is_wanted() {
            let info = self.served.scenario.recording_info(self.served.flight.tuning())?;
            let inputs = self.served.scenario.input_files();
            let planned_s = self.served.scenario.settings.planned_s();
            if let Some(said) = self.flight_recorder.begin(&info, &inputs, planned_s)? {
                tracing::warn!("{said}");
                self.hub.notice(None, NoticeLevel::Info, &said);
            }
        }
        Ok(())
    }

    pub(super) fn end_recording(&mut self, verdict: &str) {
        self.flight_recorder.end(RecordingEnd {
            state_hash: self.served.flight.state_hash(),
            verdict: verdict.to_owned(),
        });
    }

    pub(super) fn publish_news(&self, news: Vec<News>) {
        for news in news {
            match news {
                News::Finished(said) => {
                    tracing::info!("{said}");
                    self.hub.notice(None, NoticeLevel::Info, &said);
                }
                News::Failed(error) => self.alarm(&error),
            }
        }
    }

    /// The verdict of a recording that ends before its flight: the signal that ended the program, or nothing.
    pub(super) fn landing(&self) -> String {
        let signal = interruption::requested();
        signal.map_or_else(String::new, |signal| {
            format!("{}: {signal} at {:.2} s", Verdict::Interrupted, self.served.t_s)
        })
    }
}
