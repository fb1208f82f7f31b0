//! The comparison as one page that opens offline.

use std::fmt::Write;

use super::align::{overlap, seconds};
use super::{Comparison, Flown, Pair, SIGNALS};
use crate::evaluate::pictures::{Curve, Picture, stacked};
use twin_core::tick::Tick;
use twin_scenario::Row;
use twin_scenario::differences::Difference;
use twin_scenario::markup::{self, escaped};

const STYLE: &str = "
td.n{text-align:right}td.better{color:light-dark(#00684a,#4fd6a5)}td.worse{color:light-dark(#a33c00,#ff9a5c)}
code{font:12px/1.4 ui-monospace,monospace;overflow-wrap:anywhere}.tables{display:grid;gap:0 32px;
grid-template-columns:repeat(auto-fit,minmax(min(100%,460px),1fr))}
table{display:block;overflow-x:auto}
";

/// Most points of a curve.
const MOST_POINTS: usize = 1200;

/// The page of `comparison`, with curves of `flights`.
pub fn page(flights: &[Flown], comparison: &Comparison) -> String {
    let mut body = String::new();
    let names: Vec<&str> = flights.iter().map(|flown| flown.name.as_str()).collect();
    let _ = write!(body, "<h1>{}</h1>", escaped(&names.join(" · ")));
    for pair in &comparison.others {
        described(&mut body, &comparison.first, pair);
    }
    let _ = write!(
        body,
        "<h2>Signals</h2><p>Above all flights, below the difference from {}.</p>",
        escaped(&comparison.first)
    );
    for signal in SIGNALS {
        body.push_str(&drawn(flights, comparison, signal));
    }
    markup::page("twin compare", STYLE, &body)
}

/// Differences and metrics of one flight.
fn described(body: &mut String, first: &str, pair: &Pair) {
    let _ = write!(
        body,
        "<h2>{} beside {}</h2><p>Both flew for {:.2} s; {:+.2} s are added to the times of {}.</p><div class=\"tables\"><div>",
        escaped(&pair.name),
        escaped(first),
        pair.overlap_s,
        pair.offset_s,
        escaped(&pair.name)
    );
    let _ = write!(body, "<h3>What differs</h3>");
    let settings = pair.settings.as_deref().unwrap_or_default();
    differ(body, pair.facts.iter().chain(settings), first, &pair.name);
    if pair.settings.is_none() {
        let _ = write!(
            body,
            "<p>One of the recordings has no scenario, so settings are not compared.</p>"
        );
    }
    let _ = write!(body, "</div><div><h3>Metrics</h3>");
    metrics(body, &pair.metrics, first, &pair.name);
    let _ = write!(body, "</div></div>");
}

fn differ<'a>(
    body: &mut String,
    all: impl Iterator<Item = &'a Difference>,
    first: &str,
    other: &str,
) {
    let mut rows = String::new();
    for Difference { key, from, to } in all {
        let [key, from, to] = [key, from, to].map(|text| escaped(text));
        let _ = write!(
            rows,
            "<tr><td>{key}</td><td><code>{from}</code></td><td><code>{to}</code></td></tr>"
        );
    }
    if rows.is_empty() {
        let _ = write!(body, "<p>Nothing: same program, seed and settings.</p>");
        return;
    }
    let [first, other] = [first, other].map(escaped);
    let _ = write!(body, "<table><tr><th></th><th>{first}</th><th>{other}</th></tr>{rows}</table>");
}

fn metrics(body: &mut String, rows: &[Row], first: &str, other: &str) {
    let [first, other] = [first, other].map(escaped);
    let _ = write!(
        body,
        "<table><tr><th>metric</th><th>{first}</th><th>{other}</th><th>difference</th><th></th></tr>"
    );
    let cell =
        |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"));
    for Row { metric, value, parent, difference, judgement } in rows {
        let word = judgement.word();
        let difference = difference.map_or_else(|| "–".to_owned(), |value| format!("{value:+.4}"));
        let _ = write!(
            body,
            "<tr><td>{metric}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{difference}</td><td class=\"{word}\">{word}</td></tr>",
            cell(*parent),
            cell(*value),
        );
    }
    let _ = write!(body, "</table>");
}

/// The curves of a signal, and those of its differences; empty if no flight has it.
fn drawn(flights: &[Flown], comparison: &Comparison, signal: &str) -> String {
    let Some(read) = twin_scenario::checks::reader(signal) else { return String::new() };
    let Some((first, others)) = flights.split_first() else { return String::new() };
    let origin_s = first.recording.ticks.first().map_or(0.0, |tick| tick.measurement.t_s);
    let at = |place: isize| origin_s + seconds(place);
    let offset = |pair: &Pair| (pair.offset_s / twin_core::notation::TICK_S).round() as isize;
    let offsets = std::iter::once(0).chain(comparison.others.iter().map(offset));
    let curve = |(flown, offset): (&Flown, isize)| {
        let ticks = flown.recording.ticks.iter().enumerate();
        let points =
            ticks.filter_map(|(place, tick)| Some((at(place.cast_signed() + offset), read(tick)?)));
        Curve { name: flown.name.clone(), points: thinned(points.collect()), measured: false }
    };
    let overlaid = Picture {
        title: signal.to_owned(),
        x: format!("t of {}, s", first.name),
        y: signal.to_owned(),
        curves: flights.iter().zip(offsets).map(curve).collect(),
        ..Picture::default()
    };
    let difference = |(other, pair): (&Flown, &Pair)| {
        let both = overlap(&first.recording.ticks, &other.recording.ticks, offset(pair));
        let apart =
            |(one, two): &(&Tick, &Tick)| Some((one.measurement.t_s, read(two)? - read(one)?));
        let points: Vec<_> = both.iter().filter_map(apart).collect();
        Curve { name: other.name.clone(), points: thinned(points), measured: false }
    };
    let apart = Picture {
        title: format!("{signal}: difference"),
        y: "difference".to_owned(),
        curves: others.iter().zip(&comparison.others).map(difference).collect(),
        x: overlaid.x.clone(),
        ..Picture::default()
    };
    if overlaid.curves.iter().all(|curve| curve.points.is_empty()) {
        return String::new();
    }
    stacked(&[overlaid, apart])
}

/// At most [`MOST_POINTS`] points, at equal distances.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let step = points.len().div_ceil(MOST_POINTS).max(1);
    points.into_iter().step_by(step).collect()
}
