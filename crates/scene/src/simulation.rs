//! A scene in motion: bodies spawned, timed actions carried out, probes sampled, expectations judged. The clock that
//! times the steps is read here, outside the engine.

use crate::bodies::{Group, Target};
use crate::characters::{CharacterGroup, CharacterRecords};
use crate::error::SceneError;
use crate::joints::{JointGroup, JointLook, JointRecords, measured};
use crate::load::Scene;
use crate::plan::{Action, Look, Movers, Push, step_at, step_from};
use crate::probe::{EventCounts, Records, Seen, evaluate};
use crate::ragdolls::{Bones, Hold, Leading, Led, RagdollGroup, RagdollRecords, is_led, turn_between};
use crate::report::{Judge, Report, StepTimes};
use crate::samples::Samples;
use crate::systems::System;
use crate::vehicles::{Chassis, Driver, VehicleGroup, VehicleRecords, input, toward};
use jounce::math::WorldPose;
use jounce::tasks::Tasks;
use jounce::{
    BodyId, BodyKind, Command, EmitterId, Event, FieldDesc, FieldId, FieldLaw, JointId, JointRef, Ragdoll,
    StateHasher, VehicleId, VehicleInput, World,
};
use std::sync::Arc;
use std::time::Instant;

/// A running scene.
///
/// ```no_run
/// use jounce_scene::{LoadOptions, Scene, Simulation};
/// # fn main() -> Result<(), jounce_scene::SceneError> {
/// let scene = Scene::load("scenes/tower.json", &LoadOptions::default())?;
/// let mut simulation = Simulation::new(&scene, jounce::tasks::Tasks::serial())?;
/// for _ in 0..simulation.steps_for(scene.seconds()) {
///     simulation.step()?;
/// }
/// let report = simulation.finish();
/// assert!(report.passed());
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Simulation {
    scene: Scene,
    world: World,
    records: Records,
    joints: JointRecords,
    counts: EventCounts,
    fields: Vec<FieldId>,
    /// Of each entry of `emitters`.
    emitters: Vec<Vec<EmitterId>>,
    systems: Vec<System>,
    vehicles: VehicleRecords,
    drivers: Vec<Driver>,
    characters: CharacterRecords,
    ragdolls: RagdollRecords,
    /// Timed actions by step, entry and occurrence, in the order they act.
    due: Vec<Due>,
    next: usize,
    active: Vec<Active>,
    values: Vec<f64>,
    samples: Samples,
    judges: Vec<Judge>,
    times: StepTimes,
    warnings: Warnings,
    start_energy: f64,
    palette: usize,
    /// Things that the action under way meant and that had gone.
    gone: usize,
}

/// What was said, and of what it needs not be said again.
#[derive(Clone, Default)]
struct Warnings {
    said: Vec<String>,
    systems: Vec<bool>,
    emitters: Vec<bool>,
    limits: Vec<&'static str>,
    /// Entries of the timeline that met something that had gone.
    gone: Vec<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Due {
    step: u64,
    entry: usize,
    occurrence: u64,
}

/// Something that goes on for several steps.
#[derive(Clone)]
enum Active {
    Push { until: u64, target: Target, push: Push },
    Move { from_step: u64, until: u64, body: BodyId, from: WorldPose, to: WorldPose },
    Drive { from_step: u64, until: u64, vehicle: VehicleId, from: VehicleInput, to: VehicleInput },
    Lead(Led),
}

impl Simulation {
    /// Spawns the scene's bodies into a world that steps on `tasks`.
    ///
    /// # Errors
    /// [`SceneError::Run`] where the engine refuses a body.
    pub fn new(scene: &Scene, tasks: Tasks) -> Result<Self, SceneError> {
        let refused = |e: jounce::Error| SceneError::Run {
            scene: scene.name.clone(),
            time: 0.0,
            message: e.to_string(),
        };
        let mut world = World::new(scene.world.clone()).map_err(refused)?;
        world.set_tasks(tasks);
        let names = scene.probes.iter().map(|(n, _)| n.clone()).collect();
        let mut s = Self {
            world,
            records: Records::default(),
            joints: JointRecords::default(),
            counts: EventCounts::new(&scene.probes),
            fields: Vec::new(),
            emitters: Vec::new(),
            systems: scene.systems.clone(),
            vehicles: VehicleRecords::default(),
            drivers: Vec::new(),
            characters: CharacterRecords::default(),
            ragdolls: RagdollRecords::default(),
            due: due(scene),
            next: 0,
            active: Vec::new(),
            values: Vec::new(),
            samples: Samples::new(names),
            judges: scene
                .expects
                .iter()
                .zip(&scene.spec.expect)
                .map(|(e, spec)| Judge::new(e, spec))
                .collect(),
            times: StepTimes::default(),
            warnings: Warnings::default(),
            start_energy: 0.0,
            palette: 0,
            gone: 0,
            scene: scene.clone(),
        };
        let groups = std::mem::take(&mut s.scene.groups);
        let spawned = groups.iter().try_for_each(|g| s.spawn(g, 0));
        s.scene.groups = groups;
        spawned?;
        let movers = s.scene.movers.clone();
        s.add_movers(&movers, 0)?;
        let joints = std::mem::take(&mut s.scene.joints);
        let joined = s.join(&joints, None);
        s.scene.joints = joints;
        joined?;
        s.lay_mortar()?;
        s.add_fields()?;
        s.add_emitters()?;
        s.start_energy = s.world.energy().total();
        s.sample();
        Ok(s)
    }

    /// Number of steps that a time takes.
    pub fn steps_for(&self, seconds: f64) -> u64 {
        step_at(seconds, self.scene.world.rate_hz)
    }

    /// One step: timed actions that are due, the engine's step, probes, expectations.
    ///
    /// # Errors
    /// [`SceneError::Run`] where the engine refuses a timed action or the step.
    pub fn step(&mut self) -> Result<(), SceneError> {
        self.act()?;
        self.look_ahead()?;
        let start = Instant::now();
        let stepped = self.world.step();
        stepped.map_err(|e| self.refused(&e))?;
        for s in &mut self.systems {
            s.advance(&self.world);
        }
        self.times.add(start.elapsed().as_secs_f64() * 1e3);
        self.warn();
        // What an action causes at once (a contact that ends by a removal) is at the head of the step's list.
        self.counts.add(&self.scene.probes, &self.records, &self.world);
        self.sample();
        Ok(())
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The engine's world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The engine's world, for callers that add to a scene.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Probes over time.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The last number of each probe, in the order of the file; NaN while its body is not there.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// A body by `name` or `name[n]`; of several, the first.
    pub fn body(&self, name: &str) -> Option<BodyId> {
        self.records.by_text(name).first().copied()
    }

    /// All bodies of `name`, or the one of `name[n]`, made so far; some may be removed by now.
    pub fn bodies(&self, name: &str) -> &[BodyId] {
        self.records.by_text(name)
    }

    /// All joints of `name`, or the one of `name[n]`, made so far; some may be removed by now.
    pub fn joints(&self, name: &str) -> &[JointId] {
        self.joints.by_text(name)
    }

    /// All vehicles of `name`, or the one of `name[n]`; some may be removed by now.
    pub fn vehicles(&self, name: &str) -> &[VehicleId] {
        self.vehicles.by_text(name)
    }

    /// How the scene wants a joint to look.
    pub fn joint_look(&self, joint: JointId) -> JointLook {
        self.joints.look(joint)
    }

    /// Systems of points and springs.
    pub fn systems(&self) -> &[System] {
        &self.systems
    }

    /// Probes are kept of every n-th step from now on (expectations still see every step). Default 1.
    pub fn sample_every(&mut self, steps: u64) {
        self.samples.keep_every(steps);
    }

    /// Colour of a body in pictures: red, green, blue in 0…1 (sRGB). Given in the scene, or from a fixed palette in
    /// the order of creation; grey for fixed bodies.
    pub fn color(&self, body: BodyId) -> [f32; 3] {
        self.records.get(body).map_or([0.7; 3], |r| r.color)
    }

    /// The report of the run so far.
    pub fn finish(&self) -> Report {
        let mut report = Report::new(&self.scene, &self.world, &self.times, self.start_energy, &self.judges);
        if !self.systems.is_empty() {
            let mut h = StateHasher::default();
            h.word(self.world.hash());
            self.systems.iter().for_each(|s| s.hash(&mut h));
            report.hash = format!("{:#018x}", h.finish());
        }
        report.warnings = self.warnings.said.clone();
        report
    }

    /// Limits that were reached and systems that stopped, each once with the time of the first.
    pub fn warnings(&self) -> &[String] {
        &self.warnings.said
    }

    /// Notes what a reader of the numbers has to know.
    fn warn(&mut self) {
        let t = self.world.time();
        let w = &mut self.warnings;
        w.systems.resize(self.systems.len(), false);
        for (told, s) in w.systems.iter_mut().zip(&self.systems) {
            if let Some(stopped) = s.failed_at().filter(|_| !*told) {
                *told = true;
                let why = "its numbers were no longer finite; it stands still since then. Shorten its step_s, or take \
                           the method implicit_euler";
                w.said.push(format!("system \"{}\" stopped at t = {stopped:.6} s: {why}", s.name()));
            }
        }
        w.emitters.resize(self.emitters.len(), false);
        for (n, told) in w.emitters.iter_mut().enumerate().filter(|(_, told)| !**told) {
            let full = |e: &&EmitterId| self.world.emitter(**e).is_ok_and(|e| e.unborn() > 0);
            let Some(id) = self.emitters[n].iter().find(full) else { continue };
            *told = true;
            let room = self.world.emitter(*id).map_or(0, |e| e.desc().max_particles);
            let name = match self.scene.emitters.get(n).and_then(|e| e.name.as_ref()) {
                Some(name) => format!("emitter \"{name}\""),
                None => format!("emitters[{n}]"),
            };
            let all = jounce::limits::PARTICLES_MAX;
            w.said.push(format!(
                "{name} had no room for more particles at t = {t:.6} s: its max_particles is {room}, all emitters \
                 together hold {all}; it goes on without the rest"
            ));
        }
        for e in self.world.events() {
            let Event::LimitReached { what } = *e else { continue };
            if what != "particles" && !w.limits.contains(&what) {
                w.limits.push(what);
                w.said.push(format!(
                    "the limit of {what} was reached at t = {t:.6} s; the run went on without the excess"
                ));
            }
        }
    }

    fn refused(&self, e: &jounce::Error) -> SceneError {
        SceneError::Run { scene: self.scene.name.clone(), time: self.world.time(), message: e.to_string() }
    }

    fn spawn(&mut self, g: &Group, made: usize) -> Result<(), SceneError> {
        let family = self.family(g.templates.len());
        for n in 0..g.len() {
            let desc = g.body(n, made);
            let id = self.world.add_body(desc).map_err(|e| self.refused(&e))?;
            let shade = family + n % g.templates.len() + if g.single { 0 } else { n / g.templates.len() };
            self.record(g, n, made, id, shade)?;
        }
        Ok(())
    }

    /// Takes colours from the palette.
    fn family(&mut self, colors: usize) -> usize {
        let family = self.palette;
        self.palette += colors;
        family
    }

    /// Notes what a body of a group is called, looks like, and where it starts.
    fn record(
        &mut self,
        g: &Group,
        n: usize,
        made: usize,
        id: BodyId,
        shade: usize,
    ) -> Result<(), SceneError> {
        let body = self.world.body(id).map_err(|e| self.refused(&e))?;
        let (kind, pose) = (body.kind(), body.pose());
        let color = g.template(n).color.unwrap_or_else(|| crate::color::of(kind, shade));
        self.records.add(g, n, made, id, color, pose);
        Ok(())
    }

    /// Adds these vehicles, characters and ragdolls, in the order of the file; `time` is how often they were added before. A vehicle
    /// on a bone comes after the ragdolls.
    fn add_movers(&mut self, m: &Movers, time: usize) -> Result<(), SceneError> {
        let waits = |s: &Self, g: &VehicleGroup| match &g.chassis {
            Chassis::Own(_) => false,
            Chassis::Of(body) => s.records.of(body).is_empty(),
        };
        let vehicles = std::mem::take(&mut self.scene.vehicles);
        let some = m.vehicles.clone().filter_map(|i| Some((i, vehicles.get(i)?)));
        let (late, some): (Vec<_>, Vec<_>) = some.partition(|(_, g)| waits(self, g));
        let done = some.into_iter().try_for_each(|(i, g)| self.add_vehicles(i, g, time * g.len()));
        let done = done.and_then(|()| self.add_walkers(m, time));
        let done = done
            .and_then(|()| late.into_iter().try_for_each(|(i, g)| self.add_vehicles(i, g, time * g.len())));
        self.scene.vehicles = vehicles;
        done
    }

    /// Characters and ragdolls.
    fn add_walkers(&mut self, m: &Movers, time: usize) -> Result<(), SceneError> {
        let characters = std::mem::take(&mut self.scene.characters);
        let some = characters.get(m.characters.clone()).unwrap_or_default();
        let done = some.iter().try_for_each(|g| self.add_characters(g, time * g.group.len()));
        self.scene.characters = characters;
        done?;
        let ragdolls = std::mem::take(&mut self.scene.ragdolls);
        let some = ragdolls.get(m.ragdolls.clone()).unwrap_or_default();
        let done = some.iter().try_for_each(|g| self.add_ragdolls(g, time * g.len()));
        self.scene.ragdolls = ragdolls;
        done
    }

    fn add_vehicles(&mut self, entry: usize, g: &VehicleGroup, made: usize) -> Result<(), SceneError> {
        let family = self.family(1);
        for n in 0..g.len() {
            let chassis = match &g.chassis {
                Chassis::Own(own) => {
                    let id = self.world.add_body(own.body(n, made)).map_err(|e| self.refused(&e))?;
                    self.record(own, n, made, id, family + n)?;
                    id
                }
                Chassis::Of(target) => {
                    let found = self.records.of(target).first().copied();
                    let Some(id) = found.filter(|id| self.world.body(*id).is_ok()) else {
                        self.gone += 1;
                        continue;
                    };
                    id
                }
            };
            let id = self.world.add_vehicle(g.vehicle(made + n, chassis)).map_err(|e| self.refused(&e))?;
            self.apply(Command::SetVehicleInput(id, g.input))?;
            self.vehicles.add(g.name.as_ref(), id);
            if g.route.is_some() {
                self.drivers.push(Driver { vehicle: id, entry, way: 0.0, hold: 0.0 });
            }
        }
        Ok(())
    }

    fn add_characters(&mut self, g: &CharacterGroup, made: usize) -> Result<(), SceneError> {
        let family = self.family(1);
        for n in 0..g.group.len() {
            let id = self.world.add_character(g.character(n, made)).map_err(|e| self.refused(&e))?;
            self.apply(Command::SetCharacterInput(id, g.input))?;
            let body = self.world.character(id).map_err(|e| self.refused(&e))?.body();
            self.record(&g.group, n, made, body, family + n)?;
            self.characters.add(g.group.name.as_ref(), id);
        }
        Ok(())
    }

    fn add_ragdolls(&mut self, g: &RagdollGroup, made: usize) -> Result<(), SceneError> {
        let family = self.family(1);
        for n in 0..g.len() {
            let doll = self.world.add_ragdoll(&g.ragdoll(made + n)).map_err(|e| self.refused(&e))?;
            for (i, &body) in doll.bodies.iter().enumerate() {
                self.record(&g.bodies, n * g.bones() + i, made * g.bones(), body, family + n)?;
            }
            for (i, joint) in doll.joints.iter().enumerate() {
                if let (Some(id), Some(bone), Some(name)) = (*joint, g.bone_name(i), &g.name) {
                    self.joints.add_named(&bone, id);
                    self.joints.add_named(name, id);
                }
            }
            self.ragdolls.add(g.name.as_ref(), doll);
        }
        Ok(())
    }

    /// Drivers who follow lines do what the line asks for.
    fn look_ahead(&mut self) -> Result<(), SceneError> {
        let mut drivers = std::mem::take(&mut self.drivers);
        let done = drivers.iter_mut().try_for_each(|d| {
            let route = self.scene.vehicles.get(d.entry).and_then(|g| g.route.as_ref());
            let input = route.and_then(|r| d.drive(r, &self.world));
            input.map_or(Ok(()), |i| self.apply(Command::SetVehicleInput(d.vehicle, i)))
        });
        self.drivers = drivers;
        done
    }

    fn drive(
        &mut self,
        target: &Target,
        given: &crate::spec::VehicleInputSpec,
        now: u64,
        steps: u64,
    ) -> Result<(), SceneError> {
        let all = self.vehicles.of(target).to_vec();
        for id in self.there(&all, |w, id| w.vehicle(id).is_ok()) {
            let Ok(v) = self.world.vehicle(id) else { continue };
            let from = v.input();
            // Values were checked when the scene was read.
            let Ok(to) = input(from, given) else { continue };
            self.drivers.retain(|d| d.vehicle != id);
            self.active.retain(|a| !matches!(a, Active::Drive { vehicle, .. } if *vehicle == id));
            self.active.push(Active::Drive { from_step: now, until: now + steps, vehicle: id, from, to });
        }
        Ok(())
    }

    fn grab(&mut self, hold: &Hold, occurrence: u64) -> Result<(), SceneError> {
        let Some(&body) = self.records.of(&hold.body).first() else {
            self.gone += 1;
            return Ok(());
        };
        // Whoever is gone by now is not held.
        let Ok(b) = self.world.body(body) else {
            self.gone += 1;
            return Ok(());
        };
        let at = b.pose().transform_point(hold.point);
        let grab = self.world.grab(body, at, hold.spring, hold.max_force).map_err(|e| self.refused(&e))?;
        let family = self.family(1);
        self.record(&hold.hand, 0, occurrence as usize, grab.hand, family)
    }

    /// Adds joints, gears last since they name others. What `spawn` adds leaves out joints whose ends have gone.
    fn join(&mut self, groups: &[JointGroup], spawned: Option<u64>) -> Result<(), SceneError> {
        let occurrence = spawned.unwrap_or(0);
        let made: Vec<usize> = groups.iter().map(|g| self.joints.made(g.name.as_ref())).collect();
        for gears in [false, true] {
            let some = groups.iter().zip(&made).filter(|(g, _)| g.is_gear() == gears);
            for (g, made) in some {
                for n in 0..g.len() {
                    let ends = [g.end(n, 0, occurrence), g.end(n, 1, occurrence)];
                    let lost = |e: &crate::joints::Wanted<'_>| match gears {
                        true => self.joints.get(e.name, e.index).is_none_or(|j| self.world.joint(j).is_err()),
                        false => self
                            .records
                            .get_named(e.name, e.index)
                            .is_none_or(|b| self.world.body(b).is_err()),
                    };
                    if spawned.is_some() && ends.iter().any(lost) {
                        self.gone += 1;
                        continue;
                    }
                    let desc = if gears {
                        let [a, b] = ends.map(|e| (self.joints.get(e.name, e.index), e));
                        let ids = [a, b]
                            .map(|(id, e)| id.ok_or_else(|| self.absent(g, n, "joint", e.name, e.index)));
                        let [a, b] = ids;
                        g.gear(n, [a?, b?], *made)
                    } else {
                        let there = ends.map(|e| {
                            let id = self.records.get_named(e.name, e.index);
                            let found = id.and_then(|id| Some((id, self.world.body(id).ok()?.pose())));
                            found.ok_or_else(|| self.absent(g, n, "body", e.name, e.index))
                        });
                        let [a, b] = there;
                        g.joint(n, [a?, b?], *made)
                    };
                    let id = self.world.add_joint(desc).map_err(|e| self.refused(&e))?;
                    self.joints.add(g, id);
                }
            }
        }
        Ok(())
    }

    /// Welds the bodies of each entry of `mortar` that touch.
    fn lay_mortar(&mut self) -> Result<(), SceneError> {
        for n in 0..self.scene.mortar.len() {
            let m = &self.scene.mortar[n];
            let bodies: Vec<BodyId> = m.bodies.iter().flat_map(|t| self.records.of(t)).copied().collect();
            let welds = self.world.glue(&bodies, &m.desc);
            let entry = format!("mortar[{n}]");
            let welds = welds.map_err(|e| self.refused(&e).within(&entry))?;
            if welds.is_empty() {
                let (scene, time) = (self.scene.name.clone(), self.world.time());
                let expected = format!("at least {} m² with no gap above {} m", m.desc.area_min, m.desc.gap);
                let message = format!("no two of its bodies share a face; expected {expected}");
                return Err(SceneError::Run { scene, time, message }.within(&entry));
            }
            for id in m.name.iter().flat_map(|name| welds.iter().map(move |id| (name, *id))) {
                self.joints.add_named(id.0, id.1);
            }
        }
        Ok(())
    }

    fn absent(&self, g: &JointGroup, n: usize, what: &str, name: &str, index: usize) -> SceneError {
        let joint = g.label(n, 0).map_or_else(|| "a joint".into(), |l| format!("joint \"{l}\""));
        let message = format!("{joint}: {what} \"{name}\" number {index} is not there; expected one that is");
        SceneError::Run { scene: self.scene.name.clone(), time: self.world.time(), message }
    }

    /// Applies a command to every joint of a target that is still there.
    fn each_joint(
        &mut self,
        target: &Target,
        command: impl Fn(JointId, &JointRef<'_>) -> Command,
    ) -> Result<(), SceneError> {
        let all = self.joints.of(target).to_vec();
        for id in self.there(&all, |w, id| w.joint(id).is_ok()) {
            let Ok(command) = self.world.joint(id).map(|j| command(id, &j)) else { continue };
            self.apply(command)?;
        }
        Ok(())
    }

    /// Carries out what is due and what goes on.
    fn act(&mut self) -> Result<(), SceneError> {
        let now = self.world.step_count();
        while let Some(due) = self.due.get(self.next).copied().filter(|d| d.step <= now) {
            self.next += 1;
            // The timeline is moved out for the call and back: an action needs the whole simulation.
            let timeline = std::mem::take(&mut self.scene.timeline);
            self.gone = 0;
            let done =
                timeline.get(due.entry).map_or(Ok(()), |e| self.action(&e.action, due.occurrence, now));
            self.scene.timeline = timeline;
            done.map_err(|e| e.within(&format!("timeline[{}]", due.entry)))?;
            self.tell_gone(due.entry);
        }
        self.go_on(now)
    }

    /// An action leaves out what has gone; that is told once for each entry.
    fn tell_gone(&mut self, entry: usize) {
        if self.gone == 0 || self.warnings.gone.contains(&entry) {
            return;
        }
        self.warnings.gone.push(entry);
        let (n, t) = (self.gone, self.world.time());
        let what = if n == 1 {
            "one thing that it means was".into()
        } else {
            format!("{n} things that it means were")
        };
        self.warnings
            .said
            .push(format!("timeline[{entry}]: {what} not there at t = {t:.6} s; it was left out"));
    }

    /// What of these is there; the rest is counted as gone, and what was not made yet as one.
    fn there<T: Copy>(&mut self, all: &[T], is: impl Fn(&World, T) -> bool) -> Vec<T> {
        self.gone += usize::from(all.is_empty());
        let there: Vec<T> = all.iter().copied().filter(|x| is(&self.world, *x)).collect();
        self.gone += all.len() - there.len();
        there
    }

    fn action(&mut self, action: &Action, occurrence: u64, now: u64) -> Result<(), SceneError> {
        let steps = |duration: f64| step_at(duration, self.scene.world.rate_hz).max(1);
        match action {
            Action::Spawn(groups, joints, movers) => {
                let time = occurrence as usize;
                groups.iter().try_for_each(|g| self.spawn(g, time * g.len()))?;
                self.add_movers(movers, time)?;
                self.join(joints, Some(occurrence))?;
                self.let_attract()
            }
            Action::EnableVehicle(target, on) => {
                let all = self.vehicles.of(target).to_vec();
                let there = self.there(&all, |w, id| w.vehicle(id).is_ok());
                there.into_iter().try_for_each(|id| self.apply(Command::SetVehicleEnabled(id, *on)))
            }
            Action::Push { target, push, duration } => {
                let until = now + steps(*duration);
                if push.force.is_some() || push.torque.is_some() {
                    self.active.push(Active::Push { until, target: target.clone(), push: *push });
                    if push.impulse.is_none() && push.angular_impulse.is_none() {
                        // Whom it does not find is told now, as of the others: it goes on apart from its entry.
                        let _ = self.poses(target);
                    }
                }
                let impulse = push.impulse.map(|j| move |b| Command::AddImpulse(b, j, push.at));
                if let Some(impulse) = impulse {
                    self.each(target, impulse)?;
                }
                push.angular_impulse
                    .map_or(Ok(()), |l| self.each(target, |b| Command::AddAngularImpulse(b, l)))
            }
            Action::SetVelocity { target, velocity, angular_velocity } => {
                velocity.map_or(Ok(()), |v| self.each(target, |b| Command::SetVelocity(b, v)))?;
                angular_velocity.map_or(Ok(()), |w| self.each(target, |b| Command::SetAngularVelocity(b, w)))
            }
            Action::Remove(target) => self.each(target, Command::RemoveBody),
            Action::Teleport { target, position, rotation } => {
                for (body, pose) in self.poses(target) {
                    let (p, q) = (position.unwrap_or(pose.p), rotation.unwrap_or(pose.q));
                    self.apply(Command::Teleport(body, p, q))?;
                }
                Ok(())
            }
            Action::MoveTo { target, position, rotation, duration } => {
                let until = now + steps(*duration);
                for (body, from) in self.poses(target) {
                    let to = WorldPose::new(position.unwrap_or(from.p), rotation.unwrap_or(from.q));
                    self.active.push(Active::Move { from_step: now, until, body, from, to });
                }
                Ok(())
            }
            Action::SetGravity(g) => self.apply(Command::SetGravity(*g)),
            Action::Wake(target) => self.each(target, Command::Wake),
            Action::Sleep(target) => self.each(target, Command::Sleep),
            Action::Enable(target, on) => self.each(target, |b| Command::SetBodyEnabled(b, *on)),
            Action::Explode(e) => self.apply(Command::Explode(*e)),
            Action::Emit(n, count) => {
                let there = self.emitters_of(*n);
                there.into_iter().try_for_each(|e| self.apply(Command::EmitBurst(e, *count)))
            }
            Action::SetEmitter(n, on) => {
                let there = self.emitters_of(*n);
                there.into_iter().try_for_each(|e| self.apply(Command::SetEmitterEnabled(e, *on)))
            }
            Action::Cut(target) => self.each_joint(target, |j, _| Command::RemoveJoint(j)),
            Action::EnableJoint(target, on) => {
                self.each_joint(target, |j, _| Command::SetJointEnabled(j, *on))
            }
            Action::SetMotor(target, motor) => {
                self.each_joint(target, |j, r| Command::SetJoint(j, Box::new(motor.put(r.kind()))))
            }
            Action::SetJoint(target, kind, measure) => self.each_joint(target, |j, r| {
                let (mut kind, [a, b]) = ((**kind).clone(), r.anchors());
                measured(&mut kind, *measure, (b - a).length() as f32);
                Command::SetJoint(j, Box::new(kind))
            }),
            Action::Drive { target, input, duration } => self.drive(target, input, now, steps(*duration)),
            Action::Walk(target, wish) => {
                let all = self.characters.of(target).to_vec();
                for id in self.there(&all, |w, id| w.character(id).is_ok()) {
                    let Ok(input) = self.world.character(id).map(|c| wish.put(c.input())) else { continue };
                    self.apply(Command::SetCharacterInput(id, input))?;
                }
                Ok(())
            }
            Action::Pose(p) => {
                for doll in self.left_of(&p.target) {
                    let Some(g) = self.scene.ragdolls.get(p.entry) else { continue };
                    p.put(g, &doll, &mut self.world).map_err(|e| self.refused(&e))?;
                }
                Ok(())
            }
            Action::Relax(bones) => {
                for doll in self.left_of(&bones.target) {
                    bones.relax(&doll, &mut self.world).map_err(|e| self.refused(&e))?;
                }
                Ok(())
            }
            Action::Lead(way) => self.lead(way, now),
            Action::Release(bones) => self.release(bones),
            Action::Grab(hold) => self.grab(hold, occurrence),
            Action::SetField(n, on) => {
                let Some(&id) = self.fields.get(*n) else { return Ok(()) };
                let mut desc = self.world.field(id).map_err(|e| self.refused(&e))?.clone();
                desc.enabled = *on;
                self.apply(Command::SetField(id, Box::new(desc)))
            }
        }
    }

    /// Ragdolls without the joints that are gone: what is left of a doll goes on.
    fn left_of(&mut self, target: &Target) -> Vec<Ragdoll> {
        let mut dolls = self.ragdolls.of(target).to_vec();
        self.gone += usize::from(dolls.is_empty());
        for doll in &mut dolls {
            for joint in &mut doll.joints {
                if joint.is_some_and(|j| self.world.joint(j).is_err()) {
                    *joint = None;
                    self.gone += 1;
                }
            }
        }
        dolls
    }

    /// Takes bones on their way; what led them before lets go of them.
    fn lead(&mut self, way: &Arc<Leading>, now: u64) -> Result<(), SceneError> {
        let rate_hz = self.scene.world.rate_hz;
        let dolls = self.ragdolls.of(&way.target).to_vec();
        self.gone += usize::from(dolls.is_empty());
        for (n, doll) in dolls.iter().enumerate() {
            let copy = way.target.index.unwrap_or(0) + n;
            let Some(g) = self.scene.ragdolls.get(way.entry) else { continue };
            let Some(led) = Led::start(way, g, (copy, doll), &self.world, (now, rate_hz)) else {
                self.gone += 1;
                continue;
            };
            self.gone += led.lost;
            let bones: Vec<BodyId> = led.bones.iter().map(|b| b.1).collect();
            self.end_ways(&bones);
            bones.iter().try_for_each(|b| self.apply(Command::SetKind(*b, BodyKind::Kinematic)))?;
            self.active.push(Active::Lead(led));
        }
        Ok(())
    }

    /// Gives bones back to physics.
    fn release(&mut self, bones: &Bones) -> Result<(), SceneError> {
        let dolls = self.ragdolls.of(&bones.target).to_vec();
        self.gone += usize::from(dolls.is_empty());
        for doll in &dolls {
            let some = doll.bodies.iter().enumerate().filter(|(i, _)| bones.some.has(*i));
            let some: Vec<BodyId> = some.map(|(_, b)| *b).collect();
            self.end_ways(&some);
            let there = self.there(&some, |w, b| w.body(b).is_ok());
            there.into_iter().try_for_each(|b| self.apply(Command::SetKind(b, BodyKind::Dynamic)))?;
        }
        Ok(())
    }

    fn end_ways(&mut self, bones: &[BodyId]) {
        for a in &mut self.active {
            if let Active::Lead(led) = a {
                led.bones.retain(|b| !bones.contains(&b.1));
            }
        }
    }

    /// Adds the scene's emitters, in the order of the file.
    fn add_emitters(&mut self) -> Result<(), SceneError> {
        for n in 0..self.scene.emitters.len() {
            let entry = self.scene.emitters[n].clone();
            let body = entry.body.as_ref().and_then(|t| self.records.of(t).first().copied());
            let mut ids = Vec::with_capacity(entry.descs.len());
            for mut desc in entry.descs {
                desc.body = body;
                ids.push(self.world.add_emitter(desc).map_err(|e| self.refused(&e))?);
            }
            self.emitters.push(ids);
        }
        Ok(())
    }

    /// Handles of an entry of `emitters` that are still there: some remove themselves when they have ended.
    fn emitters_of(&mut self, n: usize) -> Vec<EmitterId> {
        let all = self.emitters.get(n).map_or(&[][..], Vec::as_slice);
        let there: Vec<_> = all.iter().copied().filter(|e| self.world.emitter(*e).is_ok()).collect();
        self.gone += usize::from(there.is_empty());
        there
    }

    /// Adds the scene's fields, in the order of the file.
    fn add_fields(&mut self) -> Result<(), SceneError> {
        for n in 0..self.scene.fields.len() {
            let desc = self.with_bodies(n, self.scene.fields[n].desc.clone());
            let id = self.world.add_field(desc).map_err(|e| self.refused(&e))?;
            self.fields.push(id);
        }
        Ok(())
    }

    /// The bodies that a field names and that are there now.
    fn with_bodies(&self, n: usize, mut desc: FieldDesc) -> FieldDesc {
        if let FieldLaw::NBody { bodies, .. } = &mut desc.law {
            let mut all: Vec<BodyId> = Vec::new();
            for target in &self.scene.fields[n].bodies {
                all.extend(self.records.of(target).iter().filter(|b| self.world.body(**b).is_ok()));
            }
            // Names may overlap: `star[0]` beside `star`.
            all.sort_unstable();
            all.dedup();
            *bodies = all;
        }
        desc
    }

    /// Bodies that came late attract too.
    fn let_attract(&mut self) -> Result<(), SceneError> {
        for n in 0..self.fields.len() {
            if self.scene.fields[n].bodies.is_empty() {
                continue;
            }
            let id = self.fields[n];
            let desc = self.world.field(id).map_err(|e| self.refused(&e))?.clone();
            let desc = self.with_bodies(n, desc);
            self.apply(Command::SetField(id, Box::new(desc)))?;
        }
        Ok(())
    }

    fn go_on(&mut self, now: u64) -> Result<(), SceneError> {
        let mut active = std::mem::take(&mut self.active);
        active.retain(|a| match a {
            Active::Push { until, .. } => *until > now,
            // A body removed on the way ends its way.
            Active::Move { until, body, .. } => *until > now && self.world.body(*body).is_ok(),
            Active::Drive { until, vehicle, .. } => *until > now && self.world.vehicle(*vehicle).is_ok(),
            Active::Lead(l) => l.until > now && l.bones.iter().any(|b| is_led(&self.world, b.1)),
        });
        let done = active.iter().try_for_each(|a| match a {
            Active::Push { target, push, .. } => {
                push.force.map_or(Ok(()), |f| self.each(target, |b| Command::AddForce(b, f, push.at)))?;
                push.torque.map_or(Ok(()), |t| self.each(target, |b| Command::AddTorque(b, t)))
            }
            Active::Move { from_step, until, body, from, to } => {
                let part = (now + 1 - from_step) as f64 / (until - from_step) as f64;
                let pose = between(from, to, part);
                self.apply(Command::MoveTo(*body, pose.p, pose.q))
            }
            Active::Drive { from_step, until, vehicle, from, to } => {
                let part = (now + 1 - from_step) as f64 / (until - from_step) as f64;
                self.apply(Command::SetVehicleInput(*vehicle, toward(from, to, part)))
            }
            Active::Lead(led) => {
                let Some(g) = self.scene.ragdolls.get(led.entry()) else { return Ok(()) };
                let moves = led.go_on(g, &self.world, now);
                moves.into_iter().try_for_each(|m| self.apply(m))
            }
        });
        self.active = active;
        done
    }

    /// Bodies of a target that are still there, with their poses.
    fn poses(&mut self, target: &Target) -> Vec<(BodyId, WorldPose)> {
        let all = self.records.of(target).to_vec();
        let there = self.there(&all, |w, b| w.body(b).is_ok());
        there.into_iter().filter_map(|b| Some((b, self.world.body(b).ok()?.pose()))).collect()
    }

    /// Applies a command to every body of a target that is still there.
    fn each(&mut self, target: &Target, command: impl Fn(BodyId) -> Command) -> Result<(), SceneError> {
        let all = self.records.of(target).to_vec();
        self.there(&all, |w, b| w.body(b).is_ok()).into_iter().try_for_each(|b| self.apply(command(b)))
    }

    fn apply(&mut self, command: Command) -> Result<(), SceneError> {
        self.world.apply(command).map(|_| ()).map_err(|e| self.refused(&e))
    }

    fn sample(&mut self) {
        let seen = Seen {
            world: &self.world,
            records: &self.records,
            joints: &self.joints,
            counts: &self.counts,
            systems: &self.systems,
            emitters: &self.emitters,
            vehicles: &self.vehicles,
            drivers: &self.drivers,
            characters: &self.characters,
        };
        let look = |(n, (_, look)): (usize, &(String, Look))| evaluate(look, n, &seen);
        self.values = self.scene.probes.iter().enumerate().map(look).collect();
        self.samples.push(self.world.step_count(), self.world.time(), &self.values);
        let step = self.world.step_count();
        for (judge, e) in self.judges.iter_mut().zip(&self.scene.expects) {
            if e.from <= step && step <= e.at {
                judge.see(self.values[e.probe], step == e.at);
            }
        }
    }
}

/// The timeline by steps: an action acts before the first step that starts at or after its time.
fn due(scene: &Scene) -> Vec<Due> {
    let mut all = Vec::new();
    for (entry, t) in scene.timeline.iter().enumerate() {
        for occurrence in 0..t.times {
            let time = t.at + t.every * occurrence as f64;
            let step = step_from(time, scene.world.rate_hz);
            all.push(Due { step, entry, occurrence });
        }
    }
    all.sort_unstable();
    all
}

/// The pose a part of the way, turning at a constant rate.
fn between(from: &WorldPose, to: &WorldPose, part: f64) -> WorldPose {
    let p = from.p + (to.p - from.p) * part;
    WorldPose::new(if part >= 1.0 { to.p } else { p }, turn_between(from.q, to.q, part))
}
