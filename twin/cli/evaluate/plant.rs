//! `twin evaluate plant`: the plant against published curves.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;
use twin_lab::evaluate::Sheet;
use twin_lab::evaluate::pictures::Picture;
use twin_lab::evaluate::plant::{Point, Section, sections};
use twin_scenario::Scenario;
use twin_scenario::markup::escaped;

use super::output::{Output, inputs_of};
use crate::cli::{End, Overrides, print};

/// Shown below the options of `twin evaluate plant --help`.
const HELP: &str = "\
The command drives each effect of the plant alone until it has settled, and compares it with the curve of its source. The exit code \
is 1 if a point is off by more than its line allows.

  twin evaluate plant --html plant.html                        the curves beside each other
  twin evaluate plant --set vehicle.rotor.blade_area_m2=0.02   other blades";

#[derive(Args)]
#[command(after_help = HELP)]
pub(super) struct PlantArgs {
    /// Scenario whose vehicle and air are compared.
    #[arg(default_value = "scenarios/hover.toml")]
    scenario: PathBuf,
    /// Thrust in still air of the speed at which a single rotor is examined, N [default: its part of the vehicle's weight].
    #[arg(long)]
    rotor_thrust: Option<f64>,
    #[command(flatten)]
    pub(super) output: Output,
    #[command(flatten)]
    overrides: Overrides,
}

const HEAD: [&str; 6] = ["effect", "compared", "twin", "published", "allowed", "unit"];

pub(super) fn run(args: &PlantArgs) -> anyhow::Result<End> {
    if let Some(thrust_n) = args.rotor_thrust {
        ensure!(thrust_n > 0.0, "--rotor-thrust: found {thrust_n}; expected more than 0 N");
    }
    let places = args.output.reserve(inputs_of(std::slice::from_ref(&args.scenario)))?;
    let scenario = Scenario::load(&args.scenario, &args.overrides.set)?;
    let sections = sections(&scenario, args.rotor_thrust)?;
    let mut sheet = Sheet::new(HEAD);
    sheet.rows.extend(sections.iter().flat_map(cells));
    let outputs = places.write_pictures("The plant and its sources", &sheet, || {
        Ok(sections.iter().map(section_html).collect())
    })?;
    print(&outputs, |out| {
        if args.output.json {
            writeln!(out, "{}", json(&sections))?;
        } else {
            print_table(out, &sections)?;
        }
        Ok(())
    })?;
    let agrees = sections.iter().all(|section| section.points.iter().all(Point::agrees));
    Ok(if agrees { End::Passed } else { End::Failed })
}

fn cells(section: &Section) -> impl Iterator<Item = Vec<String>> {
    section.points.iter().map(|point| {
        let figures = [point.twin, point.published, point.allowed].map(|v| format!("{v:.5}"));
        let [twin, published, allowed] = figures;
        let title = section.title.to_owned();
        vec![title, point.at.clone(), twin, published, allowed, point.unit.to_owned()]
    })
}

/// Heading, source and pictures of an effect.
fn section_html(section: &Section) -> String {
    let pictures: String = section.pictures.iter().map(Picture::svg).collect();
    format!("<h2>{}</h2><p>{}</p>{pictures}", escaped(section.title), escaped(section.source))
}

fn json(sections: &[Section]) -> serde_json::Value {
    let of = |section: &Section| {
        let curves = section.pictures.iter().flat_map(|picture| {
            picture.curves.iter().map(|curve| {
                serde_json::json!({
                    "picture": picture.title, "x": picture.x, "y": picture.y,
                    "name": curve.name, "points": curve.points,
                })
            })
        });
        serde_json::json!({
            "effect": section.title, "source": section.source, "points": section.points,
            "curves": curves.collect::<Vec<_>>(),
        })
    };
    let effects: Vec<_> = sections.iter().map(of).collect();
    serde_json::json!({ "table": "plant", "command": super::command(), "effects": effects })
}

fn print_table(out: &mut dyn Write, sections: &[Section]) -> io::Result<()> {
    for section in sections {
        writeln!(out, "{}\n  {}", section.title, section.source)?;
        for point in &section.points {
            let mark = if point.agrees() { "" } else { "  OFF" };
            writeln!(
                out,
                "    {:58} twin {:>10.5}  published {:>10.5}  ± {:.5} {}{mark}",
                point.at, point.twin, point.published, point.allowed, point.unit,
            )?;
        }
    }
    writeln!(out, "\n{}", super::command())
}
