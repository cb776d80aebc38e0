//! A scene, read and checked.

use crate::bodies::{Census, Group, Names, color, group, scatter};
use crate::characters::CharacterGroup;
use crate::emitters::{Emitters, emitters};
use crate::error::{Checked, SceneError, Under, Wrong};
use crate::fields::{Field, fields};
use crate::joints::{JointGroup, JointNames, Mortar, find_ends, group as joint_group, mortar};
use crate::limits;
use crate::mesh::{MeshData, triangles_max};
use crate::plan::{
    Action, Cast, Entry, Expect, Look, Made, Movers, Named, Sources, expects, made, probes, step_at,
    step_from, timeline,
};
use crate::ragdolls::RagdollGroup;
use crate::read::read;
use crate::shapes::{Library, settings};
use crate::spec::{SceneSpec, TrailsSpec, VehicleSpec};
use crate::systems::{System, systems};
use crate::vehicles::{Chassis, VehicleGroup};
use jounce::math::{DVec3, Quat, Vec3};
use jounce::{World, WorldDesc};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// How to load a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Folder that `assets:` names resolve in. A scene that needs it is skipped where it is absent.
    pub assets: PathBuf,
}

impl Default for LoadOptions {
    /// `../shared/assets`, beside the checkout.
    fn default() -> Self {
        Self { assets: PathBuf::from("../shared/assets") }
    }
}

/// A scene file, read, checked and resolved: ready for any number of simulations.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) name: String,
    pub(crate) spec: SceneSpec,
    pub(crate) world: WorldDesc,
    pub(crate) groups: Vec<Group>,
    pub(crate) joints: Vec<JointGroup>,
    pub(crate) mortar: Vec<Mortar>,
    /// Those of `spawn` too, as characters and ragdolls.
    pub(crate) vehicles: Vec<VehicleGroup>,
    pub(crate) characters: Vec<CharacterGroup>,
    pub(crate) ragdolls: Vec<RagdollGroup>,
    /// Which of them are there from the start.
    pub(crate) movers: Movers,
    pub(crate) fields: Vec<Field>,
    pub(crate) emitters: Vec<Emitters>,
    pub(crate) systems: Vec<System>,
    pub(crate) timeline: Vec<Entry>,
    pub(crate) probes: Vec<(String, Look)>,
    pub(crate) expects: Vec<Expect>,
}

impl Scene {
    /// Reads a scene file and the meshes it names.
    ///
    /// # Errors
    /// [`SceneError::Fault`] with the place of the first mistake; [`SceneError::Skipped`] where the scene needs an
    /// assets folder that is absent; [`SceneError::File`] where the file cannot be read.
    pub fn load(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let file = path.display().to_string();
        let wrong = |message: String| SceneError::File { file: file.clone(), message };
        let meta = std::fs::metadata(path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => wrong("there is no such file; expected a scene".into()),
            _ => wrong(format!("cannot be read: {e}")),
        })?;
        if !meta.is_file() || meta.len() > limits::SCENE_BYTES_MAX as u64 {
            let limit = limits::SCENE_BYTES_MAX;
            return Err(wrong(format!("is not a file of at most {limit} bytes; expected a scene")));
        }
        let bytes = std::fs::read(path).map_err(|e| wrong(format!("cannot be read: {e}")))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            wrong(format!("is not UTF-8 at byte {}; expected a scene as JSON", e.utf8_error().valid_up_to()))
        })?;
        let here = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let name = path.file_stem().and_then(|s| s.to_str()).unwrap_or("scene");
        Self::parse(&text, &file, name, &here, options)
    }

    /// Reads a scene from a text. `file` is for messages; meshes are relative to the current folder.
    ///
    /// # Errors
    /// As [`Scene::load`].
    #[allow(clippy::should_implement_trait)] // A scene also needs its name and options.
    pub fn from_str(text: &str, file: &str, options: &LoadOptions) -> Result<Self, SceneError> {
        Self::parse(text, file, "scene", Path::new(""), options)
    }

    fn parse(
        text: &str,
        file: &str,
        name: &str,
        here: &Path,
        options: &LoadOptions,
    ) -> Result<Self, SceneError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let spec = read(file, text)?;
        resolve(spec, name, here, options).map_err(|w| w.locate(file, text))
    }

    /// The scene's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What the scene shows.
    pub fn description(&self) -> Option<&str> {
        self.spec.description.as_deref()
    }

    /// The file's content.
    pub fn spec(&self) -> &SceneSpec {
        &self.spec
    }

    /// Gravity, step and settings.
    pub fn world_desc(&self) -> &WorldDesc {
        &self.world
    }

    /// Length of a run, s: what the scene says; or up to its last expectation, and a second beyond the end of its last timed
    /// action; or 5.
    pub fn seconds(&self) -> f64 {
        let asked = self.spec.expect.iter().map(|e| e.at);
        let acts = self.timeline.iter().map(|t| t.end() + 1.0);
        let last = asked.chain(acts).fold(0.0, |a, b| if b > a { b } else { a });
        let otherwise = if last > 0.0 { last } else { 5.0 };
        self.spec.seconds.unwrap_or(if otherwise > limits::SECONDS_MAX {
            limits::SECONDS_MAX
        } else {
            otherwise
        })
    }

    /// Joints that are there from the start, but for those of mortar: a simulation finds out where bodies touch.
    pub fn joints(&self) -> usize {
        let dolls = self.ragdolls[self.movers.ragdolls.clone()].iter().map(RagdollGroup::joints);
        self.joints.iter().map(JointGroup::len).chain(dolls).sum()
    }

    /// Bodies that are there from the start.
    pub fn bodies(&self) -> usize {
        let vehicles = self.vehicles[self.movers.vehicles.clone()].iter().map(VehicleGroup::own_bodies);
        let characters = self.characters[self.movers.characters.clone()].iter().map(|c| c.group.len());
        let dolls = self.ragdolls[self.movers.ragdolls.clone()].iter().map(|r| r.bodies.len());
        self.groups.iter().map(Group::len).chain(vehicles).chain(characters).chain(dolls).sum()
    }
}

fn resolve(spec: SceneSpec, name: &str, here: &Path, options: &LoadOptions) -> Checked<Scene> {
    let world = world_desc(&spec)?;
    let mut census = Census::default();
    let mut shelf = Shelf { here, options, read: BTreeSet::new(), bytes: 0, distinct: 0, triangles: 0 };
    let read = |file: &str| shelf.take(file);
    let mut library = Library::new(&spec.materials, &spec.meshes, read)?;
    let mut names = Names::default();
    let mut groups = Vec::new();
    for (i, b) in spec.bodies.iter().enumerate() {
        let g = group(b, &mut library, &mut census).index(i).key("bodies")?;
        name_all(&g, &mut names).index(i).key("bodies")?;
        groups.push(g);
    }
    for (i, s) in spec.scatter.iter().enumerate() {
        let g = scatter(s, &mut library, &mut census).index(i).key("scatter")?;
        name_all(&g, &mut names).index(i).key("scatter")?;
        groups.push(g);
    }
    trial(&spec, &world, &groups)?;
    let mut joint_names = JointNames::default();
    let mut cast = Cast::default();
    let mut named = Named { bodies: &mut names, joints: &mut joint_names };
    let start = (&spec.vehicles[..], &spec.characters[..], &spec.ragdolls[..]);
    let movers = cast.add(start, 1, &mut library, &mut census, &mut named)?;
    let joints = joints(&spec, &names, &mut joint_names, &mut census)?;
    let mortar = mortar(&spec.mortar, &names, &mut joint_names)?;
    let fields = fields(&spec.fields, &names)?;
    let emitters = emitters(&spec.emitters, &mut library, &names)?;
    let systems = systems(&spec.systems, 1.0 / (world.rate_hz * f64::from(world.substeps)))?;
    let mut named = Named { bodies: &mut names, joints: &mut joint_names };
    let made = made(&spec.timeline, &mut library, &mut census, &mut named, &mut cast)?;
    carried(&spec, &world, &groups, &made, &cast, &movers)?;
    let sources = Sources {
        fields: &fields,
        emitters: &emitters,
        systems: &systems,
        vehicles: (&cast.vehicles.1, &cast.vehicles.0),
        characters: &cast.characters.1,
        ragdolls: (&cast.ragdolls.1, &cast.ragdolls.0),
    };
    let timeline = timeline(&spec.timeline, made, &named, &sources)?;
    within_reach(&timeline, &groups, &cast)?;
    let probes = probes(&spec.probes, &named, &sources)?;
    let expects = expects(&spec.expect, &probes, world.rate_hz)?;
    within(&spec, world.rate_hz)?;
    looks(&spec, &names)?;
    let name = spec.name.clone().unwrap_or_else(|| name.into());
    Ok(Scene {
        name,
        world,
        groups,
        joints,
        mortar,
        vehicles: cast.vehicles.0,
        characters: cast.characters.0,
        ragdolls: cast.ragdolls.0,
        movers,
        fields,
        emitters,
        systems,
        timeline,
        probes,
        expects,
        spec,
    })
}

/// All joints that are there from the start: first their names, then what they join, since gears name joints.
fn joints(
    spec: &SceneSpec,
    names: &Names,
    joint_names: &mut JointNames,
    census: &mut Census,
) -> Checked<Vec<JointGroup>> {
    let mut all = Vec::with_capacity(spec.joints.len());
    for (i, j) in spec.joints.iter().enumerate() {
        let g = joint_group(j, census).index(i).key("joints")?;
        joint_names.add(&g, 1).index(i).key("joints")?;
        all.push(g);
    }
    for (i, (g, j)) in all.iter_mut().zip(&spec.joints).enumerate() {
        find_ends(g, j, &spec.joints, names, joint_names, &BTreeMap::new()).index(i).key("joints")?;
    }
    Ok(all)
}

/// Nothing may be said of a time that a run of the scene's own length does not reach: it would pass in silence.
fn within(spec: &SceneSpec, rate_hz: f64) -> Checked<()> {
    let Some(seconds) = spec.seconds else { return Ok(()) };
    let end = step_at(seconds, rate_hz);
    let late = |at: f64, expected: String, i: usize, list: &str| {
        Err(Wrong::new(format!("is {at}, beyond the end of the run"), expected).key("at").index(i).key(list))
    };
    if let Some((i, e)) = spec.expect.iter().enumerate().find(|(_, e)| step_at(e.at, rate_hz) > end) {
        return late(e.at, format!("at most `seconds`, {seconds}"), i, "expect");
    }
    if let Some((i, t)) = spec.timeline.iter().enumerate().find(|(_, t)| step_from(t.at, rate_hz) >= end) {
        let last = (end as f64 - 1.0) / rate_hz;
        let expected =
            format!("no later than the last step of `seconds`, {seconds}, which starts at {last:.4}");
        return late(t.at, expected, i, "timeline");
    }
    Ok(())
}

/// Puts every template into a world once: what the engine refuses (a mass out of range, …) is told with its place.
fn trial(spec: &SceneSpec, world: &WorldDesc, groups: &[Group]) -> Checked<()> {
    let mut world = World::new(world.clone())?;
    let single = groups.iter().take(spec.bodies.len()).enumerate();
    for (i, g) in single {
        try_one(&mut world, g, 0).index(i).key("bodies")?;
    }
    for (i, g) in groups.iter().skip(spec.bodies.len()).enumerate() {
        for t in 0..g.templates.len() {
            try_one(&mut world, g, t).index(t).key("bodies").index(i).key("scatter")?;
        }
    }
    Ok(())
}

/// Puts every vehicle on a body of the scene once, for what the engine refuses: wheels too heavy for it, above all.
fn carried(
    spec: &SceneSpec,
    world: &WorldDesc,
    groups: &[Group],
    made: &[Made],
    cast: &Cast,
    start: &Movers,
) -> Checked<()> {
    let mut world = World::new(world.clone())?;
    let spawned = made.iter().flat_map(|((groups, ..), _)| groups);
    let all: Vec<&Group> = groups.iter().chain(spawned).collect();
    let mut one = |i: usize, v: Option<&VehicleSpec>| {
        let Some(g) = cast.vehicles.0.get(i) else { return Ok(()) };
        let Chassis::Of(body) = &g.chassis else { return Ok(()) };
        let of_group = || all.iter().find(|o| o.name.as_ref() == Some(&body.name));
        let of_group = || of_group().map(|o| o.template(body.index.unwrap_or(0)).desc.clone());
        let of_doll = || cast.ragdolls.0.iter().find_map(|d| d.desc_of(body));
        let Some(own) = of_group().or_else(of_doll) else { return Ok(()) };
        let id = world.add_body(own)?;
        let added = world.add_vehicle(g.vehicle(0, id));
        world.remove_body(id)?;
        let Err(e) = added else { return Ok(()) };
        let wheel = v.is_some_and(|v| v.wheel.as_ref().is_some_and(|w| w.mass.is_some()));
        Err(match e {
            jounce::Error::BadValue { what: "wheel", field: "mass", value, expected } => {
                let message = format!("have {value} kg together, on the body \"{}\"", body.name);
                Wrong::new(message, expected).key(if wheel { "wheel" } else { "wheels" })
            }
            e => e.into(),
        })
    };
    for i in start.vehicles.clone() {
        one(i, spec.vehicles.get(i)).index(i).key("vehicles")?;
    }
    for (n, ((_, _, movers), _)) in made.iter().enumerate() {
        let told = spec.timeline.get(n).and_then(|t| t.spawn.as_ref());
        for (k, i) in movers.vehicles.clone().enumerate() {
            let v = told.and_then(|s| s.vehicles.get(k));
            one(i, v).index(k).key("vehicles").key("spawn").index(n).key("timeline")?;
        }
    }
    Ok(())
}

/// Grabs every body of the timeline once where its description is at hand: a point far off it is told with its place.
fn within_reach(timeline: &[Entry], groups: &[Group], cast: &Cast) -> Checked<()> {
    let spawned = timeline.iter().filter_map(|t| match &t.action {
        Action::Spawn(groups, ..) => Some(groups),
        _ => None,
    });
    let own = cast.vehicles.0.iter().filter_map(|v| match &v.chassis {
        Chassis::Own(g) => Some(g),
        Chassis::Of(_) => None,
    });
    let all: Vec<&Group> = groups.iter().chain(spawned.flatten()).chain(own).collect();
    for (n, t) in timeline.iter().enumerate() {
        let Action::Grab(hold) = &t.action else { continue };
        let of_group = || all.iter().find_map(|g| g.desc_of(&hold.body)).cloned();
        let of_doll = || cast.ragdolls.0.iter().find_map(|d| d.desc_of(&hold.body));
        let Some(mut desc) = of_group().or_else(of_doll) else { continue };
        let mut world = World::new(WorldDesc::default())?;
        (desc.position, desc.rotation) = (DVec3::ZERO, Quat::IDENTITY);
        let body = world.add_body(desc)?;
        let grabbed = world.grab(body, hold.point.as_dvec3(), hold.spring, hold.max_force);
        grabbed.map_err(Wrong::from).key("grab").index(n).key("timeline")?;
    }
    Ok(())
}

fn try_one(world: &mut World, g: &Group, template: usize) -> Checked<()> {
    let added = world.add_body(g.templates[template].desc.clone())?;
    world.remove_body(added)?;
    Ok(())
}

fn name_all(g: &Group, names: &mut Names) -> Checked<()> {
    g.names(1)?.into_iter().try_for_each(|(n, bearers)| names.add(&n, bearers))
}

/// Checks camera and colours, so that a picture cannot fail for the scene's sake.
fn looks(spec: &SceneSpec, names: &Names) -> Checked<()> {
    if let Some(r) = &spec.render {
        r.background.as_deref().map(color).transpose().key("background").key("render")?;
        r.ground_color.as_deref().map(color).transpose().key("ground_color").key("render")?;
        if r.sun.is_some_and(|s| s == [0.0; 3]) {
            return Err(Wrong::new("is zero", "a direction").key("sun").key("render"));
        }
        if let Some(s) = r.sun_strength.filter(|s| !(0.0..=4.0).contains(s)) {
            return Err(Wrong::new(format!("is {s}"), "0 to 4").key("sun_strength").key("render"));
        }
        if let Some(t) = &r.trails {
            trails(t, names).key("trails").key("render")?;
        }
    }
    let Some(c) = &spec.camera else { return Ok(()) };
    if let Some(f) = c.fov_deg.filter(|f| !(1.0..=170.0).contains(f)) {
        return Err(Wrong::new(format!("is {f}"), "1 to 170 degrees").key("fov_deg").key("camera"));
    }
    if c.position == c.target.unwrap_or([0.0; 3]) {
        return Err(Wrong::new("is the same as `target`", "a place to look from")
            .key("position")
            .key("camera"));
    }
    if c.up.is_some_and(|u| u == [0.0; 3]) {
        return Err(Wrong::new("is zero", "a direction").key("up").key("camera"));
    }
    if let Some(body) = &c.follow {
        let target = names.resolve(body).key("follow").key("camera")?;
        if target.count > 1 {
            let message = format!("names {} bodies", target.count);
            return Err(Wrong::new(message, format!("one, such as {}", target.one))
                .key("follow")
                .key("camera"));
        }
    }
    Ok(())
}

fn trails(t: &TrailsSpec, names: &Names) -> Checked<()> {
    let mut count = 0;
    for (i, body) in t.bodies.iter().enumerate() {
        count += names.resolve(body).index(i).key("bodies")?.count;
    }
    if count == 0 || count > limits::TRAILS_MAX {
        let expected = format!("1 to {} bodies", limits::TRAILS_MAX);
        return Err(Wrong::new(format!("names {count} bodies"), expected).key("bodies"));
    }
    if let Some(s) = t.seconds.filter(|&s| !(s > 0.0 && s <= limits::SECONDS_MAX)) {
        return Err(Wrong::new(format!("is {s}"), "more than 0, at most 1e7 s").key("seconds"));
    }
    if let Some(w) = t.width.filter(|&w| !(w > 0.0 && w <= limits::TRAIL_WIDTH_MAX)) {
        return Err(Wrong::new(format!("is {w}"), "more than 0, at most 1000 m").key("width"));
    }
    Ok(())
}

fn world_desc(spec: &SceneSpec) -> Checked<WorldDesc> {
    let mut d = WorldDesc::default();
    d.gravity = spec.gravity.map_or(d.gravity, Vec3::from_array);
    d.rate_hz = spec.step.rate_hz.unwrap_or(d.rate_hz);
    d.substeps = spec.step.substeps.unwrap_or(d.substeps);
    d.settings = settings(&spec.settings);
    d.settings.check().map_err(|e| Wrong::from(e).key("settings"))?;
    d.check().map_err(|e| match &e {
        jounce::Error::BadValue { field: "gravity", .. } => Wrong::from(e),
        _ => Wrong::from(e).key("step"),
    })?;
    if let Some(s) = spec.seconds
        && !(0.0..=limits::SECONDS_MAX).contains(&s)
    {
        return Err(Wrong::new(format!("is {s}"), "0 to 1e7 s").key("seconds"));
    }
    Ok(d)
}

/// Where a scene's meshes come from, and what was read so far.
struct Shelf<'a> {
    here: &'a Path,
    options: &'a LoadOptions,
    read: BTreeSet<PathBuf>,
    /// Of all files, and of each once.
    bytes: u64,
    distinct: usize,
    triangles: usize,
}

impl Shelf<'_> {
    /// Reads a mesh named in a scene, from the assets folder or beside the scene.
    fn take(&mut self, file: &str) -> Result<MeshData, SceneError> {
        let path = self.path(file)?;
        let too_much = |message: String| Err(SceneError::File { file: path.display().to_string(), message });
        self.bytes += std::fs::metadata(&path).map_or(0, |m| m.len());
        if self.bytes > limits::MESH_TOTAL_BYTES {
            return too_much(format!(
                "the meshes of the scene have more than {} bytes",
                limits::MESH_TOTAL_BYTES
            ));
        }
        let mut input = 0;
        let mesh = MeshData::load_counting(&path, &mut input)?;
        if self.read.insert(path.clone()) {
            self.distinct += input;
        }
        self.triangles += mesh.triangles.len();
        let limit = triangles_max(self.distinct);
        if self.triangles > limit {
            return too_much(format!(
                "the meshes of the scene have {} triangles; expected at most {limit} from files of their sizes",
                self.triangles
            ));
        }
        Ok(mesh)
    }

    fn path(&self, file: &str) -> Result<PathBuf, SceneError> {
        let Some(rest) = file.strip_prefix("assets:") else { return Ok(self.here.join(file)) };
        if !self.options.assets.is_dir() {
            let folder = self.options.assets.display();
            return Err(SceneError::Skipped(format!(
                "{file} needs the assets folder, and {folder} is not there"
            )));
        }
        Ok(self.options.assets.join(rest))
    }
}
