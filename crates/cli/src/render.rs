//! `jounce render`: pictures and films of a scene.

use crate::args::RenderArgs;
use crate::error::{Done, Failure};
use crate::output::{note, progress};
use crate::run::{Loaded, load, say_skipped, simulate, start};
use jounce::math::{DVec3, Quat, Vec3};
use jounce::{BodyKind, FieldDesc, FieldLaw, ParticleView, Region, ShapeId, World};
use jounce_render::{
    Ball, Camera, Extras, Face, Film, Image, Look, Overlay, Pattern, RenderOptions, Rod, Skin, Stage, Trails,
    Water, add_character, add_joint, add_vehicle, contact_overlay, default_skin, render_with, sensor_overlay,
    srgb, write_whole,
};
use jounce_scene::{Scene, Simulation, System};
use std::path::Path;

pub fn render(a: &RenderArgs) -> Done {
    let film = match a.output.extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
        Some("png") => false,
        Some("gif") => true,
        _ => {
            let name = a.output.display();
            return Err(Failure::bad(format!("{name}: expected a name that ends in .png or .gif")));
        }
    };
    if !film && (a.every.is_some() || a.fps.is_some()) {
        let name = a.output.display();
        return Err(Failure::bad(format!(
            "{name}: --every and --fps speak of films; expected a name that ends in .gif, or --at T for the moment of a .png"
        )));
    }
    let scene = match load(&a.scene, &a.common)? {
        Loaded::Scene(scene) => scene,
        Loaded::Skipped(why) => return say_skipped(&a.scene, &why, false),
    };
    let size = a.size.unwrap_or(if film { (480, 270) } else { (960, 540) });
    let mut simulation = start(&a.scene, &scene, a.common.threads.unwrap_or(1))?;
    let mut painter = Painter::new(&scene, &simulation, size, a.common.threads);
    painter.caption = a.caption;
    painter.contacts = a.contacts;
    let fine = a.fine || !film;
    painter.options.light_samples = if fine { 3 } else { 1 };
    painter.options.edge_samples = if fine { 8 } else { 4 };
    if film {
        shoot(a, &scene, &mut simulation, &mut painter)
    } else {
        snap(a, &scene, &mut simulation, &mut painter)
    }
}

fn snap(a: &RenderArgs, scene: &Scene, simulation: &mut Simulation, painter: &mut Painter<'_>) -> Done {
    let count = simulation.steps_for(a.at.or(a.seconds).unwrap_or_else(|| scene.seconds()));
    let bar = progress(count, "simulate");
    simulate(&a.scene, simulation, count, &bar, |s| watch(painter, s))?;
    bar.finish_and_clear();
    painter.picture(simulation)?.write_png(&a.output)?;
    note(&format!("wrote {}", a.output.display()));
    Ok(())
}

fn shoot(a: &RenderArgs, scene: &Scene, simulation: &mut Simulation, painter: &mut Painter<'_>) -> Done {
    let seconds = a.seconds.unwrap_or_else(|| scene.seconds());
    let dt = simulation.world().dt();
    let every = a.every.unwrap_or_else(|| ((1.0 / (a.fps.unwrap_or(15.0) * dt)).round() as u64).max(1));
    let first = simulation.steps_for(a.at.unwrap_or(0.0));
    simulate(&a.scene, simulation, first, &progress(first, "simulate"), |s| watch(painter, s))?;
    let count = simulation.steps_for(seconds);
    let bytes = shoot_film(&a.scene, simulation, painter, count, every)?;
    write_whole(&a.output, &bytes)?;
    note(&format!("wrote {} ({:.2} MB)", a.output.display(), bytes.len() as f64 / 1e6));
    Ok(())
}

fn watch(painter: &mut Painter<'_>, simulation: &Simulation) -> Done {
    painter.watch(simulation);
    Ok(())
}

/// Most frames of one film.
const FRAMES_MAX: u64 = 3000;

/// A GIF of the next `count` steps, every `every`-th one drawn.
pub fn shoot_film(
    path: &Path,
    simulation: &mut Simulation,
    painter: &mut Painter<'_>,
    count: u64,
    every: u64,
) -> Done<Vec<u8>> {
    let frames = count / every;
    if frames > FRAMES_MAX {
        return Err(Failure::bad(format!(
            "the film would have {frames} frames; expected at most {FRAMES_MAX}: take a larger --every or fewer --seconds"
        )));
    }
    // Faster than GIF can show: every frame takes the shortest time that it can.
    let fps = (1.0 / (every as f64 * simulation.world().dt())).clamp(0.1, 50.0);
    let mut film = Film::new(fps)?;
    film.push(painter.picture(simulation)?)?;
    let bar = progress(count, "film");
    let mut done = 0;
    simulate(path, simulation, count, &bar, |s| {
        done += 1;
        painter.watch(s);
        // The last picture would be the first of the next round.
        if done % every == 0 && done < count {
            film.push(painter.picture(s)?)?;
        }
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(film.finish()?)
}

/// Draws a scene as its `camera` and `render` keys say.
pub struct Painter<'a> {
    scene: &'a Scene,
    pub options: RenderOptions,
    camera: Camera,
    /// Where the followed body was at the start.
    followed: DVec3,
    trails: Option<Trails>,
    /// Of joints, m.
    width: f32,
    /// Behind the points of systems that ask for it, with the system's number.
    tails: Vec<(Trails, usize)>,
    pub caption: bool,
    pub contacts: bool,
}

/// Time for which a picture's shutter is open, s.
const SHUTTER_S: f32 = 1.0 / 60.0;
/// Particles above this radius, m, are puffs.
const GRAIN_RADIUS_MAX: f32 = 0.02;

/// Draws a particle: what is brighter than white glows, what is large is a soft puff, what is small and fast a streak.
fn add_particle(p: &ParticleView, extras: &mut Extras) {
    let [r, g, b, opacity] = p.color;
    let bright = [r, g, b].into_iter().fold(0.0f32, |m, c| if c > m { c } else { m });
    let scale = if bright > 1.0 { 1.0 / bright } else { 1.0 };
    let glow = ((bright - 1.0) / 3.0).clamp(0.0, 1.0);
    let color = [r, g, b].map(|c| encoded(c * scale));
    let opacity = opacity.clamp(0.0, 1.0);
    // Not farther back than its birth.
    let way = p.velocity * SHUTTER_S.min(p.age);
    let ball = Ball::new(p.position, p.drawn_radius, color).opacity(opacity).glow(glow);
    if p.drawn_radius > GRAIN_RADIUS_MAX {
        extras.balls.push(ball.soft());
    } else if way.length() > 4.0 * p.drawn_radius {
        let from = p.position - way.as_dvec3();
        extras.rods.push(Rod::new(from, p.position, p.drawn_radius, color).opacity(opacity).glow(glow));
    } else {
        extras.balls.push(ball);
    }
}

/// Linear light as sRGB.
fn encoded(c: f32) -> f32 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// Points as balls, springs as rods, skins with smooth shading.
fn add_system(s: &System, extras: &mut Extras) {
    let (x, radius, color) = (s.positions(), s.radius(), s.color());
    if s.triangles().is_empty() {
        extras.balls.extend(x.iter().map(|p| Ball::new(*p, radius, color)));
    }
    for e in s.springs() {
        let [a, b] = e.map(|i| x[i as usize]);
        extras.rods.push(Rod::new(a, b, 0.4 * radius, color));
    }
    let mut normals = vec![DVec3::ZERO; x.len()];
    for t in s.triangles() {
        let [a, b, c] = t.map(|i| i as usize);
        let n = (x[b] - x[a]).cross(x[c] - x[a]);
        for i in [a, b, c] {
            normals[i] += n;
        }
    }
    for t in s.triangles() {
        let [a, b, c] = t.map(|i| i as usize);
        let smooth = [a, b, c].map(|i| normals[i].as_vec3().normalize_or(Vec3::Y));
        extras.faces.push(Face::new(x[a], x[b], x[c], color).normals(smooth));
    }
}

/// Width of trails and joints where the scene gives none, as a part of the camera's distance from its target.
const TRAIL_WIDTH: f64 = 0.005;

impl<'a> Painter<'a> {
    pub fn new(scene: &'a Scene, simulation: &Simulation, size: (u32, u32), threads: Option<u32>) -> Self {
        let spec = scene.spec();
        let mut look = Look::default();
        if let Some(r) = &spec.render {
            if let Some(sun) = r.sun.and_then(|s| Vec3::from_array(s).try_normalize()) {
                look.sun = sun.0;
            }
            look.sun_strength = r.sun_strength.unwrap_or(1.0);
            look.background = r.background.as_deref().and_then(hex);
        }
        let aspect = size.0 as f32 / size.1 as f32;
        let camera = spec.camera.as_ref().map_or_else(
            || Stage::camera(simulation.world(), aspect),
            |c| Camera {
                position: DVec3::from_array(c.position),
                target: DVec3::from_array(c.target.unwrap_or([0.0; 3])),
                up: Vec3::from_array(c.up.unwrap_or([0.0, 1.0, 0.0])),
                fov_deg: c.fov_deg.unwrap_or(45.0),
            },
        );
        let options = RenderOptions {
            width: size.0,
            height: size.1,
            threads: threads.map_or(0, |t| t as usize),
            look,
            ..RenderOptions::default()
        };
        let trails = spec.render.as_ref().and_then(|r| r.trails.as_ref());
        let width = ((camera.target - camera.position).length() * TRAIL_WIDTH) as f32;
        let trails = trails.map(|t| Trails::new(t.seconds, t.width.unwrap_or(width)));
        let followed = DVec3::ZERO;
        let tails = simulation.systems().iter().enumerate();
        let tails =
            tails.filter_map(|(i, s)| Some((Trails::new(Some(s.trail_s()?), s.radius() * 0.5), i))).collect();
        let mut painter =
            Self { scene, options, camera, followed, trails, width, tails, caption: false, contacts: false };
        painter.followed = painter.follow(simulation).unwrap_or(DVec3::ZERO);
        painter.watch(simulation);
        painter
    }

    /// To be called after every step: remembers what pictures show of the past.
    pub fn watch(&mut self, simulation: &Simulation) {
        let time = simulation.world().time();
        for (n, (trails, system)) in self.tails.iter_mut().enumerate() {
            let Some(s) = simulation.systems().get(*system) else { continue };
            for (i, p) in s.positions().iter().enumerate() {
                trails.record(((n as u64) << 32) | i as u64, time, *p, s.color());
            }
        }
        let spec = self.scene.spec().render.as_ref().and_then(|r| r.trails.as_ref());
        let (Some(trails), Some(spec)) = (&mut self.trails, spec) else { return };
        let world = simulation.world();
        for &id in spec.bodies.iter().flat_map(|name| simulation.bodies(name)) {
            let Ok(body) = world.body(id) else { continue };
            trails.record(id.to_bits(), world.time(), body.position(), simulation.color(id));
        }
    }

    /// What is drawn beside the world's shapes.
    fn extras(&self, simulation: &Simulation) -> Extras {
        let mut extras = Extras::default();
        if let Some(trails) = &self.trails {
            trails.add_to(simulation.world().time(), &mut extras);
        }
        for (trails, _) in &self.tails {
            trails.add_to(simulation.world().time(), &mut extras);
        }
        simulation.world().particles().for_each(|p| add_particle(&p, &mut extras));
        simulation.systems().iter().for_each(|s| add_system(s, &mut extras));
        if self.scene.spec().render.as_ref().and_then(|r| r.joints) != Some(false) {
            let world = simulation.world();
            for id in world.joints() {
                let look = simulation.joint_look(id);
                add_joint(world, id, look.width.unwrap_or(self.width), look.color, &mut extras);
            }
        }
        let world = simulation.world();
        extras.waters.extend(world.fields().filter_map(|id| water(world.field(id).ok()?)));
        world.vehicles().for_each(|id| add_vehicle(world, id, &mut extras));
        world.characters().for_each(|id| add_character(world, id, &mut extras));
        extras
    }

    fn follow(&self, simulation: &Simulation) -> Option<DVec3> {
        let name = self.scene.spec().camera.as_ref()?.follow.as_deref()?;
        let body = simulation.body(name)?;
        Some(simulation.world().body(body).ok()?.position())
    }

    fn camera_at(&self, simulation: &Simulation) -> Camera {
        let mut camera = self.camera;
        if let Some(at) = self.follow(simulation) {
            let shift = at - self.followed;
            camera.position += shift;
            camera.target += shift;
        }
        let spec = self.scene.spec().camera.as_ref();
        if let Some(rate) = spec.and_then(|c| c.orbit_deg_per_s) {
            let angle = f64::from(rate).to_radians() * simulation.world().time();
            let turn = Quat::from_axis_angle(camera.up.normalize_or(Vec3::Y), angle as f32).as_dquat();
            camera.position = camera.target + turn.rotate(camera.position - camera.target);
        }
        camera
    }

    /// The world as it is now.
    pub fn picture(&self, simulation: &Simulation) -> Done<Image> {
        let world = simulation.world();
        let grid = self.scene.spec().render.as_ref();
        let ground = grid.and_then(|r| r.ground_color.as_deref()).and_then(hex);
        let plain = grid.and_then(|r| r.ground_grid) == Some(false);
        let paint = |world: &World, shape: ShapeId| {
            let mut skin: Skin = default_skin(world, shape);
            let body = world.shape(shape).ok()?.body();
            let fixed = world.body(body).ok()?.kind() == BodyKind::Fixed;
            if fixed && plain {
                skin.pattern = Pattern::Plain;
            }
            skin.color = match ground {
                Some(color) if fixed => color,
                _ => linear(simulation.color(body)),
            };
            Some(skin)
        };
        let stage = Stage::painted(world, &paint);
        let mut overlay = Overlay::default();
        if grid.and_then(|r| r.sensors) == Some(true) {
            sensor_overlay(world, &mut overlay);
        }
        let camera = self.camera_at(simulation);
        if self.contacts {
            overlay.on_top = true;
            let longest = (camera.target - camera.position).length() as f32 * 0.05;
            contact_overlay(world, &mut overlay, longest);
        }
        if self.caption {
            overlay.caption = Some(format!("{}   t = {:.2} s", self.scene.name(), world.time()));
        }
        Ok(render_with(&stage, &camera, &self.extras(simulation), &overlay, &self.options)?)
    }
}

/// A field of water that acts, as pictures show it. Within a ball it is not drawn.
fn water(f: &FieldDesc) -> Option<Water> {
    let FieldLaw::Water { surface, normal, .. } = f.law else { return None };
    let within = match f.region {
        Region::Everywhere => None,
        Region::Box { center, half, .. } => Some((center, half)),
        Region::Sphere { .. } => return None,
    };
    f.enabled.then_some(Water { surface, normal, within })
}

/// Display colour to linear light.
fn linear(color: [f32; 3]) -> Vec3 {
    let [r, g, b] = color.map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u32);
    srgb(r << 16 | g << 8 | b)
}

/// "#rrggbb" as a linear colour.
fn hex(text: &str) -> Option<Vec3> {
    u32::from_str_radix(text.strip_prefix('#')?, 16).ok().map(srgb)
}
