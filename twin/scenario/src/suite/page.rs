//! The results as one HTML page: failures with their reasons and links to their replays, sweeps with their pictures, then all
//! cases.

use std::fmt::Write;
use std::path::Path;

use super::{CaseResult, SuiteReport, SweepReport, picture};
use crate::markup::{self, escaped};

const STYLE: &str = "
:root{--good:light-dark(#00724f,#2fc08d);--bad:light-dark(#b23a00,#ff7a4d);--warn:light-dark(#8a5a00,#e69f00)}
table{width:100%}th,td{text-align:left;vertical-align:top}
td.n{text-align:right}pre{margin:2px 0 0;white-space:pre-wrap;font:12px/1.4 ui-monospace,monospace;color:var(--muted)}
.passed{color:var(--good)}.FAILED,.ERROR{color:var(--bad);font-weight:600}.declared,.not{color:var(--warn)}
.tally b{font-size:20px;margin-right:4px}.tally span{margin-right:22px}
";

/// The page. Links to replays are relative to `folder`, the folder of the page. `wall_s` is the duration of the run, s.
pub fn html(report: &SuiteReport, folder: &Path, wall_s: f64) -> String {
    let mut body = "<h1>twin test</h1>".to_owned();
    tally(&mut body, report, wall_s);
    for sweep in &report.sweeps {
        sweep_section(&mut body, report, sweep);
    }
    body.push_str(
        "<h2>Flights</h2><table><thead><tr><th>result</th><th>case</th><th>seed</th><th>verdict</th><th>s</th>\
         <th>× real time</th><th>state hash</th></tr></thead><tbody>",
    );
    for result in report.cases.iter().filter(|result| result.case.sample.is_none()) {
        row(&mut body, result, folder);
    }
    body.push_str("</tbody></table>");
    markup::page(
        &format!("twin test: {} failed", report.failed + report.could_not_run),
        STYLE,
        &body,
    )
}

fn tally(page: &mut String, report: &SuiteReport, wall_s: f64) {
    page.push_str("<p class=\"tally\">");
    for (class, count, word) in [
        ("passed", report.passed, "passed"),
        ("FAILED", report.failed, "failed"),
        ("ERROR", report.could_not_run, "could not run"),
        ("not", report.not_run, "not run"),
    ] {
        let _ = write!(page, "<span class=\"{class}\"><b>{count}</b>{word}</span>");
    }
    page.push_str("</p>");
    if report.verdict.is_some() {
        let why = report.why_not_run();
        let _ = write!(page, "<p class=\"ERROR\">{why}: {} not run</p>", report.not_run);
    }
    let flown_s = report.flown_s();
    let _ = write!(
        page,
        "<p>{flown_s:.0} s flown in {wall_s:.0} s, {:.1} × real time; twin {} {}{}</p>",
        flown_s / wall_s.max(1e-9),
        report.version,
        report.git,
        report
            .shard
            .map_or_else(String::new, |shard| format!(", shard {} of {}", shard.index, shard.of)),
    );
}

fn sweep_section(page: &mut String, report: &SuiteReport, sweep: &SweepReport) {
    let class = match sweep.passed {
        Some(true) => "passed",
        Some(false) => "FAILED",
        None => "not",
    };
    let _ = write!(
        page,
        "<h2>Sweep {}</h2><p class=\"{class}\">{}</p>{}",
        escaped(&sweep.plan.name),
        escaped(&sweep.sentence()),
        picture::svg(report, sweep).unwrap_or_default()
    );
    let failed: Vec<&CaseResult> =
        report.samples_of(&sweep.plan.name).filter(|result| !result.passed()).collect();
    if failed.is_empty() {
        return;
    }
    let _ = write!(page, "<details><summary>{} that do not succeed</summary>", failed.len());
    for result in failed {
        let (name, message) = (escaped(&result.case.name), escaped(&result.message()));
        let _ = write!(page, "<p>{name}</p><pre>{message}</pre>");
    }
    page.push_str("</details>");
}

fn row(page: &mut String, result: &CaseResult, folder: &Path) {
    let word = result.word();
    let class = if word == "failed as declared" { "declared" } else { word };
    let _ = write!(page, "<tr><td class=\"{class}\">{word}</td><td>{}", escaped(&result.case.name));
    if let Some((replay, opens_at_s)) = &result.replay {
        let link = relative(replay, folder);
        let _ = write!(page, " · <a href=\"{}\">replay at {opens_at_s:.2} s</a>", escaped(&link));
    }
    let message = result.message();
    if !message.is_empty() {
        let _ = write!(page, "<pre>{}</pre>", escaped(&message));
    }
    let cells = result.report().map_or_else(
        || "<td></td>".repeat(5),
        |report| {
            format!(
                "<td>{}</td><td>{}</td><td class=\"n\">{:.2}</td><td class=\"n\">{:.1}</td><td>{}</td>",
                report.seed,
                report.verdict,
                report.flight_s,
                report.real_time_factor.unwrap_or(f64::NAN),
                report.state_hash
            )
        },
    );
    let _ = write!(page, "</td>{cells}</tr>");
}

/// `file` as a relative link from a page in `folder`, so that both can be moved together.
fn relative(file: &Path, folder: &Path) -> String {
    let plain = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
    };
    let (file, folder) = (plain(file), plain(folder));
    let shared = file.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| "..".to_owned());
    let down =
        file.components().skip(shared).map(|part| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_leads_from_the_page_to_the_replay() {
        let link = |file: &str, folder: &str| relative(Path::new(file), Path::new(folder));
        assert_eq!(link("out/failed/a.html", "out"), "failed/a.html");
        assert_eq!(link("failed/a.html", "reports/today"), "../../failed/a.html");
        assert_eq!(link("a.html", ""), "a.html");
    }
}
