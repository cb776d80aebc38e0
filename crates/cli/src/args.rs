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
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
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
    /// Answer a question of the textbook, without a world
    Solve(SolveArgs),
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
    /// Write the probes as a CSV file; a folder that is missing is made
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Sample probes every N steps for --csv; expectations are judged at every step
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = count, allow_negative_numbers = true, requires = "csv")]
    pub every: u64,
}

#[derive(ClapArgs)]
pub struct RenderArgs {
    #[command(flatten)]
    pub common: Common,
    /// Scene file
    pub scene: PathBuf,
    /// Picture to write: .png (one moment) or .gif (a film); a folder that is missing is made
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
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
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
    /// Probes to plot, separated by commas; a name that holds a comma in a --y of its own
    #[arg(long, value_name = "NAME", required = true)]
    pub y: Vec<String>,
    /// Logarithmic y axis
    #[arg(long)]
    pub log_y: bool,
    /// Diagram to write: .svg or .png; a folder that is missing is made
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Simulated seconds [default: as the scene says]
    #[arg(long, value_parser = seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Sample every N steps
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = count, allow_negative_numbers = true)]
    pub every: u64,
    /// Size of the diagram
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "960x540")]
    pub size: (u32, u32),
}

#[derive(ClapArgs)]
pub struct CheckArgs {
    /// Folder that `assets:` in scenes means [default: ../shared/assets beside the checkout]
    #[arg(long, value_name = "DIR")]
    pub assets: Option<PathBuf>,
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
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "1", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Vec<u32>,
    /// Fewer steps, and one repeat unless --repeats says otherwise
    #[arg(long)]
    pub quick: bool,
    /// Steps of each scene, the first of them untimed [default: the scene's own, with --quick a fifth]
    #[arg(long, value_name = "N", value_parser = steps, allow_negative_numbers = true)]
    pub steps: Option<u64>,
    /// Repeats of each scene, by turns with the other engines [default: 3]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub repeats: Option<u64>,
    /// Time the stages of our step too
    #[arg(long)]
    pub profile: bool,
    /// Print one JSON object instead of a Markdown table
    #[arg(long)]
    pub json: bool,
}

#[derive(ClapArgs)]
pub struct SolveArgs {
    #[command(subcommand)]
    pub question: Question,
}

#[derive(Subcommand)]
pub enum Question {
    /// Launch angles and times, in vacuum and in air
    ///
    /// One of --angle, --range, --apex and --target says what is asked. The launch is the origin, x points forward, y up;
    /// angles are in degrees above the horizontal, azimuths in degrees from x towards z. What cannot be reached is
    /// answered with the nearest approach, and is no error: the exit code is 0.
    ///
    /// With --mass and a drag the same is answered in air, beside the vacuum.
    Projectile(Box<ProjectileArgs>),
}

#[derive(ClapArgs)]
pub struct ProjectileArgs {
    /// Launch speed, m/s [default: the least that reaches the target, in vacuum]
    #[arg(long, value_name = "S", value_parser = above_zero, allow_hyphen_values = true)]
    pub speed: Option<f64>,
    /// Launch angle, degrees: where does it fly?
    #[arg(long, value_name = "DEG", value_parser = angle, allow_hyphen_values = true, requires = "speed", group = "question")]
    pub angle: Option<f64>,
    /// Distance to hit, m: by which angles?
    #[arg(long, value_name = "R", value_parser = above_zero, allow_hyphen_values = true, group = "question")]
    pub range: Option<f64>,
    /// Height that the apex is to have above the launch, m: by which angle?
    #[arg(long, value_name = "H", value_parser = above_zero, allow_hyphen_values = true, group = "question")]
    pub apex: Option<f64>,
    /// Point to hit, m from the launch: by which angles?
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, group = "question")]
    pub target: Option<[f64; 3]>,
    /// Height of the target of --range above the launch, m
    #[arg(long, value_name = "H", value_parser = finite, allow_hyphen_values = true, default_value = "0", requires = "range", conflicts_with_all = ["angle", "apex", "target"])]
    pub height: f64,
    /// Velocity of the target of --range or --target, m/s: where to lead?
    #[arg(long, value_name = "VX,VY,VZ", value_parser = vector, allow_hyphen_values = true, requires = "speed", conflicts_with_all = ["angle", "apex"])]
    pub moving: Option<[f64; 3]>,
    /// Height of the launch of --angle above the ground, m
    #[arg(long, value_name = "H", value_parser = not_negative, allow_hyphen_values = true, default_value = "0", requires = "angle", conflicts_with_all = ["range", "apex", "target"])]
    pub launch_height: f64,
    /// Gravity, m/s²
    #[arg(long, value_name = "G", value_parser = above_zero, allow_hyphen_values = true, default_value = "9.81")]
    pub gravity: f64,
    /// Mass of the projectile, kg
    #[arg(long, value_name = "M", value_parser = above_zero, allow_hyphen_values = true, help_heading = "Air")]
    pub mass: Option<f64>,
    /// Diameter of the projectile, a ball, m
    #[arg(long, value_name = "D", value_parser = above_zero, allow_hyphen_values = true, help_heading = "Air", requires = "mass")]
    pub diameter: Option<f64>,
    /// Drag coefficient C_d of ½ ρ A C_d v²
    #[arg(long, value_name = "CD", value_parser = not_negative, allow_hyphen_values = true, help_heading = "Air", requires = "diameter")]
    pub drag: Option<f64>,
    /// Linear drag b of b v, kg/s
    #[arg(long, value_name = "B", value_parser = not_negative, allow_hyphen_values = true, help_heading = "Air", requires = "mass")]
    pub linear_drag: Option<f64>,
    /// Density of the air, kg/m³
    #[arg(long, value_name = "RHO", value_parser = not_negative, allow_hyphen_values = true, help_heading = "Air", default_value = "1.2", requires = "diameter")]
    pub density: f64,
    /// Velocity of the wind, m/s
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, help_heading = "Air", requires = "mass")]
    pub wind: Option<[f64; 3]>,
    /// Spin, rad/s; it lifts as a sports ball's
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true, help_heading = "Air", requires = "diameter")]
    pub spin: Option<[f64; 3]>,
    /// Spin about the axis to the right of the shot, rad/s: the top turns back, the ball is lifted
    #[arg(long, value_name = "W", value_parser = finite, allow_hyphen_values = true, help_heading = "Air", requires = "diameter", conflicts_with = "spin")]
    pub backspin: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

fn above_zero(text: &str) -> Result<f64, String> {
    in_range(text, |v| (1e-12..=1e9).contains(&v), "a number above 0: 1e-12 to 1e9")
}

fn not_negative(text: &str) -> Result<f64, String> {
    in_range(text, |v| (0.0..=1e9).contains(&v), "a number from 0 to 1e9")
}

fn finite(text: &str) -> Result<f64, String> {
    in_range(text, |v| v.abs() <= 1e9, "a number from -1e9 to 1e9")
}

fn angle(text: &str) -> Result<f64, String> {
    in_range(text, |v| v.abs() <= 90.0, "-90 to 90 degrees")
}

fn vector(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<f64> = text.split(',').map_while(|p| finite(p.trim()).ok()).collect();
    let whole = text.split(',').count() == 3;
    <[f64; 3]>::try_from(parts).ok().filter(|_| whole).ok_or_else(|| {
        "expected three numbers from -1e9 to 1e9 with commas between them, such as 10,2.5,-3".into()
    })
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

fn count(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "expected a whole number, 1 or more".into())
}

fn steps(text: &str) -> Result<u64, String> {
    let ok = text.parse().ok().filter(|n| (2..=1_000_000).contains(n));
    ok.ok_or_else(|| "expected a whole number from 2 to 1000000".into())
}

fn threads(text: &str) -> Result<u32, String> {
    text.parse()
        .ok()
        .filter(|n| (1..=256).contains(n))
        .ok_or_else(|| "expected a whole number from 1 to 256".into())
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
