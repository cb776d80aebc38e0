//! `jounce plot`: probes over time.

use crate::args::PlotArgs;
use crate::error::{Done, Failure};
use crate::output::{note, progress};
use crate::run::{Loaded, load, say_skipped, simulate, start};
use jounce_render::{Plot, Series, Style, write_whole};
use jounce_scene::spec::{AggregateSpec, ProbeSpec, SceneSpec};
use jounce_scene::{Expected, Simulation};

pub fn plot(a: &PlotArgs) -> Done {
    let extension = a.output.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if extension != "svg" && extension != "png" {
        let name = a.output.display();
        return Err(Failure::bad(format!("{name}: expected a name that ends in .svg or .png")));
    }
    let scene = match load(&a.scene, &a.common)? {
        Loaded::Scene(scene) => scene,
        Loaded::Skipped(why) => return say_skipped(&a.scene, &why, false),
    };
    let known: Vec<&str> = scene.spec().probes.keys().collect();
    if let Some(name) = a.y.iter().find(|y| !known.contains(&y.as_str())) {
        let expected = if known.is_empty() { "(the scene has none)".into() } else { known.join(", ") };
        let file = a.scene.display();
        return Err(Failure::bad(format!("{file}: no probe \"{name}\"; expected one of {expected}")));
    }
    let mut simulation = start(&a.scene, &scene, a.common.threads.unwrap_or(1))?;
    let count = simulation.steps_for(a.seconds.unwrap_or_else(|| scene.seconds()));
    let bar = progress(count, "simulate");
    simulate(&a.scene, &mut simulation, count, &bar, |_| Ok(()))?;
    bar.finish_and_clear();
    let plot = Plot {
        title: scene.name().to_string(),
        y_label: label(a, scene.spec()),
        series: curves(a, &simulation),
        width: a.size.0.max(200),
        height: a.size.1.max(150),
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
fn label(a: &PlotArgs, spec: &SceneSpec) -> String {
    let of = |name: &String| spec.probes.get(name).map_or("", unit);
    let shared = of(&a.y[0]);
    let name = if a.y.len() == 1 { a.y[0].as_str() } else { "" };
    if shared.is_empty() || a.y.iter().any(|n| of(n) != shared) {
        return name.into();
    }
    format!("{name} ({shared})").trim().into()
}

/// Unit of what a probe measures; empty for counts.
fn unit(probe: &ProbeSpec) -> &'static str {
    if matches!(probe.aggregate, Some(AggregateSpec::CountBelow(_) | AggregateSpec::CountAbove(_))) {
        return "";
    }
    let what = probe.value.as_deref().or(probe.world.as_deref()).unwrap_or("");
    let group = what.split('.').next().unwrap_or("");
    match group {
        "position" | "center" | "height" | "distance" => "m",
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

/// The probes' curves, and as dots the numbers that the scene expects of them.
fn curves(a: &PlotArgs, simulation: &Simulation) -> Vec<Series> {
    let samples = simulation.samples();
    let every = usize::try_from(a.every).unwrap_or(usize::MAX);
    let mut series = Vec::new();
    for name in &a.y {
        let values = samples.column(name).unwrap_or_default();
        let points = samples.times().iter().zip(values).step_by(every).map(|(t, v)| [*t, *v]).collect();
        series.push(Series { name: name.clone(), points, style: Style::Solid });
    }
    for e in simulation.finish().expectations.into_iter().filter(|e| e.pass.is_some()) {
        let Expected::Value(v) = e.expected else { continue };
        if a.y.contains(&e.probe) {
            let name = format!("expected: {}", e.name);
            series.push(Series { name, points: vec![[e.at, v]], style: Style::Dots });
        }
    }
    series
}
