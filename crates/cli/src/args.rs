//! The words of the command line.

use clap::{Args as ClapArgs, Parser, Subcommand};
use std::path::PathBuf;

/// Deterministic game physics. Without a command: runs the showcase and writes out/showcase.gif.
#[derive(Parser)]
#[command(name = "jounce", version, about, max_term_width = 100, args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(flatten)]
    pub common: Common,
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// Words that most commands share.
#[derive(ClapArgs, Clone, Default)]
pub struct Common {
    /// Folder that `assets:` in scenes means [default: ../shared/assets beside the checkout]
    #[arg(long, value_name = "DIR")]
    pub assets: Option<PathBuf>,
    /// Threads for simulation and pictures [default: 1 for `run`, all cores for pictures]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub threads: Option<u32>,
}

#[derive(Subcommand)]
pub enum Command {
    /// Simulate a scene and print what came of it
    Run(RunArgs),
    /// Draw a scene as a PNG picture or an animated GIF
    Render(RenderArgs),
    /// Plot probes of a scene over time
    Plot(PlotArgs),
    /// Validate scene files
    Check(CheckArgs),
    /// Hold every law beside its closed form or measured data
    Verify(VerifyArgs),
    /// Time scenes, side by side with other engines
    Bench(BenchArgs),
}

#[derive(ClapArgs)]
pub struct RunArgs {
    #[command(flatten)]
    pub common: Common,
    /// Scene file
    pub scene: PathBuf,
    /// Simulated seconds [default: as the scene says]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Write the probes as a CSV file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Sample probes every N steps for --csv; expectations are judged at every step
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub every: u64,
}

#[derive(ClapArgs)]
pub struct RenderArgs {
    #[command(flatten)]
    pub common: Common,
    /// Scene file
    pub scene: PathBuf,
    /// Picture to write: .png (one moment) or .gif (a film)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Size of the picture [default: 960x540 for PNG, 480x270 for GIF]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// PNG: simulated second of the picture. GIF: second of the first frame [default: the end; 0]
    #[arg(long, value_name = "T", value_parser = time, allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Simulated seconds of a film [default: as the scene says]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Frames a second of a film [default: 15]
    #[arg(long, value_name = "F", value_parser = fps, allow_negative_numbers = true, conflicts_with = "every")]
    pub fps: Option<f64>,
    /// Draw every N-th step of a film
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub every: Option<u64>,
    /// Finer light and edges, slower
    #[arg(long)]
    pub fine: bool,
    /// Draw contact points and normal forces
    #[arg(long)]
    pub contacts: bool,
    /// Write scene name and time into the picture
    #[arg(long)]
    pub caption: bool,
}

#[derive(ClapArgs)]
pub struct PlotArgs {
    #[command(flatten)]
    pub common: Common,
    /// Scene files; several are drawn into one diagram
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Probes to plot, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',', required = true)]
    pub y: Vec<String>,
    /// Logarithmic y axis
    #[arg(long)]
    pub log_y: bool,
    /// Diagram to write: .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Simulated seconds [default: as the scene says]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Sample every N steps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub every: u64,
    /// Size of the diagram
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: (u32, u32),
}

#[derive(ClapArgs)]
pub struct CheckArgs {
    #[command(flatten)]
    pub common: Common,
    /// Scene files
    #[arg(required = true)]
    pub files: Vec<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(ClapArgs)]
pub struct VerifyArgs {
    /// Only rows whose name or topic holds this word
    pub filter: Option<String>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(ClapArgs)]
pub struct BenchArgs {
    /// Only scenes whose name holds this word [default: large_pyramid]
    pub filter: Option<String>,
    /// Other engines to run beside ours: folders of bench/peers, such as box3d
    #[arg(long, value_name = "ENGINE", value_delimiter = ',')]
    pub against: Vec<String>,
    /// Numbers of threads to run with
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub threads: Vec<u32>,
    /// Fewer steps, one repeat
    #[arg(long)]
    pub quick: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    in_range(text, |v| v > 0.0 && v <= 1e6, "more than 0, at most 1000000 seconds")
}

fn time(text: &str) -> Result<f64, String> {
    in_range(text, |v| (0.0..=1e6).contains(&v), "0 to 1000000 seconds")
}

fn fps(text: &str) -> Result<f64, String> {
    in_range(text, |v| (0.1..=50.0).contains(&v), "0.1 to 50 frames a second")
}

fn in_range(text: &str, ok: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|v| ok(*v)).ok_or_else(|| format!("expected {expected}"))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X', '×']);
    let sides = parts.and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    let fits = |v: u32| (16..=4096).contains(&v);
    sides.filter(|&(w, h)| fits(w) && fits(h)).ok_or_else(|| "expected WIDTHxHEIGHT, 16 to 4096 each".into())
}
