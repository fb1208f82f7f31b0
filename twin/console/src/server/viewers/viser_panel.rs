//! The panel for viser: status, buttons, scenario, two charts, and a slider for each gain in the folder of its group.

use rmpv::Value;

use crate::server::protocol::{FlightPhase, GainInfo, StateInfo};
use crate::server::published::Published;
use crate::server::viewers::chart;
use crate::server::viewers::controls::Button;
use crate::server::viewers::layers::LAYERS;
use crate::server::viewers::pack::{self, map};
use crate::server::viewers::viser_frame::Batch;
use twin_core::elementary::powi;

/// Start of the identifier of a slider; the name of its gain follows.
pub(super) const GAIN: &str = "gain.";

/// Start of the identifier of a button; the button's name follows.
pub(super) const BUTTON: &str = "button.";

/// Start of the identifier of a check box that shows or hides a layer; the layer's label follows.
pub(super) const SHOW: &str = "show.";

/// Identifier of the drop-down list of scenarios.
pub(super) const SCENARIO: &str = "scenario";

const STATUS: &str = "status";

/// A chart: identifier, title, and channels with label and colour.
pub(super) struct Chart {
    /// Identifier.
    pub id: &'static str,
    title: &'static str,
    /// Name, label and colour of each channel.
    pub series: &'static [(&'static str, &'static str, &'static str)],
}

/// The charts.
pub(super) const CHARTS: [Chart; 2] = [
    Chart {
        id: "chart.residual",
        title: "residual and estimate, translation",
        series: &[
            ("residual.x", "r x", "#d62728"),
            ("residual.y", "r y", "#2ca02c"),
            ("residual.z", "r z", "#1f77b4"),
            ("adapted.x", "estimate x", "#f2a6a6"),
            ("adapted.y", "estimate y", "#a3d9a3"),
            ("adapted.z", "estimate z", "#a3c8e8"),
        ],
    },
    Chart {
        id: "chart.reset",
        title: "mean innovation against the reset threshold",
        series: &[
            ("innovation_mean", "innovation", "#d55e00"),
            ("reset_threshold", "threshold", "#888888"),
        ],
    },
];

/// Builds the panel.
pub(super) fn build(published: &Published, batch: &mut Batch) {
    batch.push(&theme());
    batch.push(&map! { "type" => "SetGuiPanelLabelMessage", "label" => "twin" });
    let mut order = 0.0;
    let mut next = || {
        order += 1.0;
        order
    };
    let text = status(&published.state);
    let props = map! { "order" => next(), "_markdown" => text, "visible" => true };
    batch.push(&element("GuiMarkdownMessage", STATUS, "root", None, props));
    for (_, name) in Button::ALL {
        batch.push(&button(name, next()));
    }
    batch.push(&scenarios(published, next()));
    for (label, _) in LAYERS {
        batch.push(&check_box(label, next()));
    }
    for chart in &CHARTS {
        add_chart(chart, next(), batch);
    }
    let mut groups: Vec<&str> = Vec::new();
    for gain in &published.gains {
        let folder = format!("folder.{}", gain.group);
        if !groups.contains(&gain.group.as_str()) {
            groups.push(&gain.group);
            let props = map! {
                "order" => next(),
                "label" => gain.group.as_str(),
                "visible" => true,
                "expand_by_default" => groups.len() == 1,
            };
            batch.push(&element("GuiFolderMessage", &folder, "root", None, props));
        }
        batch.push(&slider(gain, &folder, next()));
    }
}

/// The message that sets a property of an element.
pub(super) fn update(id: &str, property: &str, value: Value) -> Value {
    map! { "type" => "GuiUpdateMessage", "uuid" => id, "updates" => map! { property => value } }
}

/// The message that sets the status line.
pub(super) fn update_status(text: &str) -> Value {
    update(STATUS, "_markdown", Value::from(text))
}

/// The message that shows a notification for eight seconds.
pub(super) fn notification(number: u64, title: &str, body: &str, colour: &str) -> Value {
    map! {
        "type" => "NotificationShowMessage",
        "uuid" => format!("notification.{number}"),
        "props" => map! {
            "title" => title,
            "body" => body,
            "loading" => false,
            "with_close_button" => true,
            "auto_close_seconds" => 8.0,
            "color" => colour,
        },
    }
}

/// The state of the flight as markdown.
pub(super) fn status(state: &StateInfo) -> String {
    let phase = match state.phase {
        FlightPhase::Flying => "flying",
        FlightPhase::Paused => "paused",
        FlightPhase::Ended => "ended",
    };
    let verdict = match (&state.verdict, &state.reason) {
        (Some(verdict), Some(reason)) => format!("\n\n**{verdict}**: {reason}"),
        _ => String::new(),
    };
    format!(
        "**{}** · seed {} · {phase} · {}\n\nt = {:.2} s · tick {} · {:.2} × real time{verdict}",
        state.scenario, state.seed, state.task_phase, state.t_s, state.tick, state.real_time_factor
    )
}

fn theme() -> Value {
    map! {
        "type" => "ThemeConfigurationMessage",
        "titlebar_content" => Value::Nil,
        "control_layout" => "floating",
        "control_width" => "medium",
        "show_logo" => false,
        "show_share_button" => false,
        "dark_mode" => false,
        "colors" => Value::Nil,
    }
}

fn element(kind: &str, id: &str, container: &str, value: Option<Value>, props: Value) -> Value {
    let mut fields = vec![(Value::from("type"), Value::from(kind)), ("uuid".into(), id.into())];
    fields.extend(value.map(|value| (Value::from("value"), value)));
    fields.push(("container_uuid".into(), container.into()));
    fields.push(("props".into(), props));
    Value::Map(fields)
}

fn button(name: &str, order: f64) -> Value {
    let props = map! {
        "order" => order,
        "label" => name,
        "hint" => Value::Nil,
        "visible" => true,
        "disabled" => false,
        "color" => Value::Nil,
        "_icon_html" => Value::Nil,
        "_hold_callback_freqs" => Value::Array(Vec::new()),
    };
    element("GuiButtonMessage", &format!("{BUTTON}{name}"), "root", Some(false.into()), props)
}

fn check_box(label: &str, order: f64) -> Value {
    let props = map! {
        "order" => order,
        "label" => label,
        "hint" => "shown in the scene",
        "visible" => true,
        "disabled" => false,
    };
    element("GuiCheckboxMessage", &format!("{SHOW}{label}"), "root", Some(true.into()), props)
}

fn scenarios(published: &Published, order: f64) -> Value {
    let mut names: Vec<&str> =
        published.scenarios.iter().map(|scenario| scenario.name.as_str()).collect();
    let current = published.state.scenario.as_str();
    if !names.contains(&current) {
        names.insert(0, current);
    }
    let props = map! {
        "order" => order,
        "label" => "scenario",
        "hint" => "restart with another scenario",
        "visible" => true,
        "disabled" => false,
        "options" => Value::Array(names.into_iter().map(Value::from).collect()),
    };
    element("GuiDropdownMessage", SCENARIO, "root", Some(current.into()), props)
}

fn slider(gain: &GainInfo, folder: &str, order: f64) -> Value {
    let unit = if gain.unit.is_empty() { String::new() } else { format!(" [{}]", gain.unit) };
    // The slider shows as many decimals as its step needs, at most those of an f64.
    let decimals = (0..12).find(|&k| {
        let scaled = gain.step * powi(10_f64, k);
        (scaled - scaled.round()).abs() < 1e-9 * scaled.max(1.0)
    });
    let props = map! {
        "order" => order,
        "label" => gain.name.as_str(),
        "hint" => format!("{}{unit}: {}", gain.label, gain.help),
        "visible" => true,
        "disabled" => false,
        "min" => gain.min,
        "max" => gain.max,
        "step" => gain.step,
        "precision" => decimals.unwrap_or(12),
        "_marks" => Value::Nil,
    };
    let id = format!("{GAIN}{}", gain.name);
    element("GuiSliderMessage", &id, folder, Some(gain.value.into()), props)
}

fn add_chart(plot: &Chart, order: f64, batch: &mut Batch) {
    let columns = chart::nothing_yet(plot.series.len()).into_iter();
    let data = columns.map(|column| batch.array("<f8", pack::f64_bytes(column))).collect();
    let mut series = vec![map! { "label" => "t, s" }];
    series.extend(
        plot.series.iter().map(
            |(_, label, colour)| map! { "label" => *label, "stroke" => *colour, "width" => 1.0 },
        ),
    );
    let props = map! {
        "order" => order,
        "data" => Value::Array(data),
        "mode" => Value::Nil,
        "title" => plot.title,
        "series" => Value::Array(series),
        "bands" => Value::Nil,
        "scales" => map! { "x" => map! { "time" => false } },
        "axes" => Value::Nil,
        "legend" => map! { "show" => true },
        "cursor" => Value::Nil,
        "focus" => Value::Nil,
        "aspect" => 1.6,
        "height" => Value::Nil,
        "padding" => Value::Nil,
        "visible" => true,
    };
    batch.push(&element("GuiUplotMessage", plot.id, "root", None, props));
}
