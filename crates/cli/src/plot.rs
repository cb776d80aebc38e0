//! `jounce plot`: probes over time.

use crate::args::PlotArgs;
use crate::error::{Done, Failure};
use crate::output::{note, progress};
use crate::run::{Loaded, load, say_skipped, simulate, start};
use jounce_render::{Plot, Series, Style, write_whole};
use jounce_scene::spec::{AggregateSpec, ProbeSpec};
use jounce_scene::{Expected, Scene};
use std::path::Path;

pub fn plot(a: &PlotArgs) -> Done {
    let extension = a.output.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if extension != "svg" && extension != "png" {
        let name = a.output.display();
        return Err(Failure::bad(format!("{name}: expected a name that ends in .svg or .png")));
    }
    let mut curves = Curves { series: Vec::new(), units: Vec::new(), names: Vec::new(), shown: Vec::new() };
    for path in &a.scenes {
        match load(path, &a.common)? {
            Loaded::Scene(scene) => curves.add(a, path, &scene)?,
            Loaded::Skipped(why) => say_skipped(path, &why, false)?,
        }
    }
    if curves.names.is_empty() {
        return Ok(());
    }
    let plot = Plot {
        title: curves.names.join(", "),
        y_label: label(&curves.shown, &curves.units),
        series: curves.series,
        width: a.size.0.max(200),
        height: a.size.1.max(150),
        log_y: a.log_y,
        ..Plot::default()
    };
    if extension == "svg" {
        write_whole(&a.output, plot.svg()?.as_bytes())?;
    } else {
        plot.image()?.write_png(&a.output)?;
    }
    note(&format!("wrote {}", a.output.display()));
    Ok(())
}

/// Name of the axis: the probe where there is one, and the unit where all share it.
fn label(shown: &[String], units: &[&str]) -> String {
    let name = shown.first().filter(|first| shown.iter().all(|s| s == *first)).map_or("", String::as_str);
    match units {
        [first, rest @ ..] if !first.is_empty() && rest.iter().all(|u| u == first) => {
            format!("{name} ({first})").trim().into()
        }
        _ => name.into(),
    }
}

/// Unit of what a probe measures; empty for counts.
fn unit(probe: &ProbeSpec) -> &'static str {
    if matches!(probe.aggregate, Some(AggregateSpec::CountBelow(_) | AggregateSpec::CountAbove(_))) {
        return "";
    }
    let what = probe.value.as_deref().or(probe.world.as_deref()).unwrap_or("");
    let group = what.split('.').next().unwrap_or("");
    match group {
        "position" | "center" | "height" | "distance" | "radius" | "lowest" | "highest" => "m",
        "velocity" | "speed" => "m/s",
        "angular_velocity" | "angular_speed" => "rad/s",
        "momentum" => "kg m/s",
        "angular_momentum" => "kg m²/s",
        "energy" | "kinetic_energy" | "potential_energy" => "J",
        "normal_force" | "friction_force" => "N",
        "tilt" | "angle" => "°",
        "mass" => "kg",
        _ => "",
    }
}

/// Most expectations of a scene that stand in the legend.
const NAMED_DOTS_MAX: usize = 4;
/// Lower diagrams have no room for their names.
const NAMED_DOTS_HEIGHT: u32 = 300;

/// What is drawn of the scenes so far.
struct Curves {
    series: Vec<Series>,
    /// Of each curve.
    units: Vec<&'static str>,
    /// Of the scenes.
    names: Vec<String>,
    /// Probes of the curves.
    shown: Vec<String>,
}

impl Curves {
    /// Runs a scene: the probes' curves, and as dots in their colours the numbers that the scene expects of them.
    fn add(&mut self, a: &PlotArgs, path: &Path, scene: &Scene) -> Done {
        let spec = scene.spec();
        let known: Vec<&str> = spec.probes.keys().collect();
        let wanted = chosen(&a.y, &known);
        if let Some(name) = wanted.iter().find(|y| !known.contains(&y.as_str())) {
            let expected = if known.is_empty() { "(the scene has none)".into() } else { known.join(", ") };
            let file = path.display();
            return Err(Failure::bad(format!("{file}: no probe \"{name}\"; expected one of {expected}")));
        }
        let mut simulation = start(path, scene, a.common.threads.unwrap_or(1))?;
        simulation.sample_every(a.every);
        let count = simulation.steps_for(a.seconds.unwrap_or_else(|| scene.seconds()));
        let bar = progress(count, "simulate");
        simulate(path, &mut simulation, count, &bar, |_| Ok(()))?;
        bar.finish_and_clear();
        let samples = simulation.samples();
        let expected = simulation.finish().expectations;
        // Two files may hold scenes of one name.
        let name = scene.name().to_string();
        let name = if self.names.contains(&name) { path.display().to_string() } else { name };
        let of = if a.scenes.len() > 1 { format!("{name}: ") } else { String::new() };
        let mut dots = 0;
        for probe in &wanted {
            let color = Some(self.units.len());
            self.shown.push(probe.clone());
            self.units.push(spec.probes.get(probe).map_or("", unit));
            let values = samples.column(probe).unwrap_or_default();
            let points = samples.times().iter().zip(values).map(|(t, v)| [*t, *v]).collect();
            self.series.push(Series { name: format!("{of}{probe}"), points, style: Style::Solid, color });
            for e in expected.iter().filter(|e| &e.probe == probe && e.pass.is_some()) {
                let Expected::Value(v) = e.expected else { continue };
                // Many names would hide the curves.
                let named = dots < NAMED_DOTS_MAX && a.size.1 >= NAMED_DOTS_HEIGHT;
                let name = if named { format!("{of}expected: {}", e.name) } else { String::new() };
                dots += 1;
                self.series.push(Series { name, points: vec![[e.at, v]], style: Style::Dots, color });
            }
        }
        self.names.push(name);
        Ok(())
    }
}

/// Names of probes out of the words of `--y`: a word that is a name as it stands, else those between its commas.
fn chosen(words: &[String], known: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    for w in words {
        if known.contains(&w.as_str()) {
            all.push(w.clone());
        } else {
            all.extend(w.split(',').map(String::from));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::chosen;

    #[test]
    fn a_name_may_hold_a_comma() {
        let words = ["a,b".to_string(), "c,d".to_string()];
        assert_eq!(chosen(&words, &["a,b", "c", "d"]), ["a,b", "c", "d"]);
        assert_eq!(chosen(&words, &["a", "b"]), ["a", "b", "c", "d"]);
    }
}
