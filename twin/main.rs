//! The command line of `twin`.

use std::path::PathBuf;
fn main() -> anyhow::Result<()> {
    let args: Vec<String> = std::env::args().collect();
    let scenario = twin::scenario::Scenario::load(&PathBuf::from(&args[1]), &args[2..])?;
    let verbose = std::env::var("V").is_ok();
    let t = std::time::Instant::now();
    let report = twin::scenario::fly(&scenario, &mut |tick| {
        if verbose { for l in twin::scenario::run::event_lines(tick) { eprintln!("{l}"); } }
        if std::env::var("VV").is_ok() && tick.index % 20 == 0 {
            let e = tick.control.error;
            eprintln!("{:.2} {} e=[{}] r=[{}] rh=[{}]", tick.measurement.t_s, tick.phase,
              e.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join(" "),
              tick.residual.iter().map(|x| format!("{x:.2}")).collect::<Vec<_>>().join(" "),
              tick.setpoint.r_hat.iter().map(|x| format!("{x:.2}")).collect::<Vec<_>>().join(" "));
        }
    })?;
    println!("{}", serde_json::to_string(&report)?);
    eprintln!("rtf {:.1}", report.flight_s / t.elapsed().as_secs_f64());
    Ok(())
}
