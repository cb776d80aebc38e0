//! Characters in the step: each looks at the world as it will stand at the end of the step where bodies are led (kinematic ones),
//! moves, and becomes the target of its body; or gives its body a force. In slot order: a later one sees where an earlier one goes.

use super::Step;
use crate::query::QueryFilter;
use crate::room::characters::around::{Ahead, Around, MoveScratch};
use crate::room::characters::desc::{CharacterGround, CharacterHit, CharacterKind, CharacterMover};
use crate::room::characters::leg::{self, Stand, clamped};
use crate::room::characters::solve::{Outcome, Walk, Wish, across};
use crate::room::characters::state::Character;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_math::{Quat, Vec3, WorldPose, scalar::f32s};

/// Parts of a way of moving bodies that are looked at one after another, at most, so that none passes a character.
const PARTS_MAX: f32 = 16.0;
/// A body that is farther from where its character left it was moved by someone else, m.
const MOVED: f64 = 1e-3;

pub(crate) fn run(world: &mut World, step: &Step) {
    if world.characters.is_empty() {
        return;
    }
    let mut all = core::mem::take(&mut world.characters);
    look_ahead(world, &all.table, step.dt, &mut all.ahead);
    for i in 0..all.table.slots() {
        let Some(c) = all.table.get_mut(i) else { continue };
        let alive = world.shapes.is_live(c.shape.index, c.shape.generation)
            && world.shapes[c.shape.index].body == c.body
            && world.bodies[c.body].enabled;
        let kind = world.bodies[c.body].kind;
        match c.desc.kind {
            CharacterKind::Walker if alive && kind == BodyKind::Kinematic => {
                walk(world, c, &mut all.ahead, &mut all.scratch, step);
            }
            CharacterKind::Dynamic { .. } if alive && kind == BodyKind::Dynamic => {
                stand(world, c, &all.ahead, &mut all.scratch, step);
            }
            _ => {}
        }
    }
    world.characters = all;
}

/// Where led bodies will be, and dynamic ones that carry someone.
fn look_ahead(world: &World, all: &crate::table::Table<Character>, dt: f32, ahead: &mut Vec<Ahead>) {
    ahead.clear();
    for (s, b) in world.awake.state.iter().zip(&world.awake.step) {
        if b.kind == BodyKind::Kinematic {
            let from = world.frames[b.body as usize].pose();
            // A velocity that came from a target ends with it.
            let still = b.guided || (s.v() == Vec3::ZERO && s.w() == Vec3::ZERO);
            let to = match b.target {
                Some(t) => t,
                None if still => continue,
                None => moved(world, b.body, s.v(), s.w(), dt),
            };
            if to != from {
                ahead.push(Ahead { body: b.body, from, to });
            }
        }
    }
    for (_, c) in all.iter() {
        let Some(g) = &c.ground else { continue };
        let Ok(slot) = world.slot(g.body) else { continue };
        let body = &world.bodies[slot];
        if body.kind == BodyKind::Dynamic && body.row != NONE {
            let s = &world.awake.state[body.row as usize];
            let from = world.frames[slot as usize].pose();
            ahead.push(Ahead { body: slot, from, to: moved(world, slot, s.v(), s.w(), dt) });
        }
    }
    ahead.sort_unstable_by_key(|a| a.body);
    ahead.dedup_by_key(|a| a.body);
}

/// A body's pose after a time at these velocities.
fn moved(world: &World, slot: u32, v: Vec3, w: Vec3, dt: f32) -> WorldPose {
    let f = &world.frames[slot as usize];
    let q = match w.try_normalize() {
        Some((axis, speed)) => (Quat::from_axis_angle(axis, speed * dt) * f.rotation).normalize(),
        None => f.rotation,
    };
    let center = f.center + (v * dt).as_dvec3();
    WorldPose::new(center - q.rotate(f.local_center).as_dvec3(), q)
}

/// A body that was moved by someone else starts anew from there.
fn find_foot(world: &World, c: &mut Character) {
    let at = world.frames[c.body as usize].pose().p;
    if (at - c.foot).length() > MOVED {
        (c.foot, c.ground) = (at, None);
    }
}

/// Spends what a step spends of the input, and forgets the last step.
fn begin(world: &mut World, c: &mut Character) {
    find_foot(world, c);
    c.hits.clear();
    (c.on_steep, c.hit_ceiling, c.squeezed, c.stepped) = (false, false, false, 0.0);
    if let Some(h) = c.input.heading.take() {
        c.heading = h;
    }
    if core::mem::take(&mut c.input.drop_through)
        && let Some(g) = c.ground
        && world.shapes.get(g.shape.index).is_some_and(|s| s.filter.layers & c.desc.mover.one_way_layers != 0)
    {
        c.passing = Some(g.shape);
    }
}

/// What a character sees.
fn around<'a>(
    world: &'a World,
    m: &'a CharacterMover,
    c: &Character,
    ahead: &'a [Ahead],
    scratch: &'a mut MoveScratch,
    filter: &'a QueryFilter<'a>,
    dt: f32,
) -> Around<'a> {
    let passing = c.passing.filter(|p| world.shapes.is_live(p.index, p.generation));
    Around {
        world,
        mover: m,
        up: m.up,
        height: c.height(),
        capsule: m.capsule(c.height()),
        turn: Quat::from_rotation_arc(Vec3::Y, m.up).normalize(),
        body: c.body,
        own: c.desc.filter,
        filter,
        ahead,
        part: 1.0,
        ignored: passing.map_or(NONE, |p| p.index),
        resist: [c.desc.push_force * dt, c.desc.mass, dt],
        scratch,
    }
}

fn walk(
    world: &mut World,
    c: &mut Character,
    ahead: &mut Vec<Ahead>,
    scratch: &mut MoveScratch,
    step: &Step,
) {
    begin(world, c);
    crouch(world, c, ahead, scratch, step.dt);
    let (dt, up, m) = (step.dt, c.desc.mover.up, c.desc.mover);
    steer(c, world.gravity, dt);
    let mut hits = core::mem::take(&mut c.hits);
    let filter = QueryFilter::default();
    let mut a = around(world, &m, c, ahead, scratch, &filter, dt);
    a.look(c.foot, c.velocity.length() * dt + m.step_height + m.snap + 8.0 * m.skin);
    let ground = c.ground.and_then(|g| world.slot(g.body).ok());
    let (way, turn) = ground.map_or((Vec3::ZERO, 0.0), |g| (a.carried(g, c.foot), a.turned(g)));
    if let Some(s) = c.passing
        && (a.ignored == NONE || !a.is_near(a.ignored, c.foot, 2.0 * m.skin))
    {
        debug_assert!(s.index == a.ignored || a.ignored == NONE);
        (c.passing, a.ignored) = (None, NONE);
    }
    let mut w = Walk::new(&mut a, &mut hits, c.foot);
    if let Some(g) = ground {
        w.carry(g, way);
    }
    shove(&mut w);
    let rise = c.velocity.dot(up) * dt;
    let grounded = (c.ground.is_some() && rise <= 0.0).then_some(up);
    let floor = grounded.map(|u| w.floor_normal().unwrap_or(u));
    w.go(&Wish { across: across(c.velocity, up) * dt, rise, grounded: floor });
    let out = w.out;
    c.hits = hits;
    if c.desc.turns_with_ground {
        c.heading += turn;
    }
    let moved = out.foot != c.foot;
    let stood = c.ground;
    settle(world, c, &out, ground.map_or(Vec3::ZERO, |_| way * (1.0 / dt)), dt);
    push(world, c, step);
    bear(world, c, stood, step.dt, moved);
    lead(world, c, way.dot(up), ahead);
}

/// Moving walls: in parts small against the radius.
fn shove(w: &mut Walk<'_, '_>) {
    let fastest = w.around.fastest_near();
    let parts = f32s::clamp((fastest / (0.25 * w.around.mover.radius)).ceil(), 1.0, PARTS_MAX);
    for i in 1..parts as u32 {
        w.around.part = i as f32 / parts;
        w.push_out();
    }
    w.around.part = 1.0;
}

/// Crouches, or stands up where there is headroom.
fn crouch(world: &mut World, c: &mut Character, ahead: &[Ahead], scratch: &mut MoveScratch, dt: f32) {
    if c.crouched == c.input.crouch || c.desc.crouch_height >= c.desc.mover.height {
        return;
    }
    let height = if c.input.crouch { c.desc.crouch_height } else { c.desc.mover.height };
    if !c.input.crouch {
        let m = &c.desc.mover;
        let filter = QueryFilter::default();
        let mut tall = around(world, m, c, ahead, scratch, &filter, dt);
        (tall.height, tall.capsule) = (height, m.capsule(height));
        tall.look(c.foot, m.skin);
        // A lift of a skin: the ground is no ceiling, and the ceiling keeps its gap.
        let foot = c.foot + (m.up * (0.9 * m.skin)).as_dvec3();
        if tall.overlaps(foot, 0.0) {
            return;
        }
    }
    if world.set_capsule(&c.desc, c.shape, height).is_ok() {
        c.crouched = c.input.crouch;
    }
}

/// Own velocity: towards what is wanted, and the fall.
fn steer(c: &mut Character, gravity: Vec3, dt: f32) {
    let d = &c.desc;
    let up = d.mover.up;
    let (mut flat, mut rise) = (across(c.velocity, up), c.velocity.dot(up));
    let grounded = c.ground.is_some() && c.input.jump.is_none() && c.passing.is_none();
    if grounded {
        flat += clamped(across(c.input.walk, up) - flat, d.acceleration * dt);
        rise = 0.0;
    } else {
        // It takes the velocity of what it stood on along.
        if let Some(g) = c.ground.filter(|_| c.input.jump.is_some() || c.passing.is_some()) {
            flat += across(g.velocity, up);
            rise = f32s::max(g.velocity.dot(up), 0.0);
        }
        if c.input.walk != Vec3::ZERO {
            flat += clamped(across(c.input.walk, up) - flat, d.air_acceleration * dt);
        }
        if let Some(j) = c.input.jump.take() {
            rise += j;
            c.ground = None;
        } else {
            rise += gravity.dot(up) * d.gravity_scale * dt;
            rise = f32s::max(rise, -d.fall_speed_max);
        }
        if c.passing.is_some() {
            c.ground = None;
        }
    }
    c.velocity = flat + up * rise;
}

/// What the move did to the velocity; ground found and lost.
fn settle(world: &World, c: &mut Character, out: &Outcome, carried: Vec3, dt: f32) {
    let up = c.desc.mover.up;
    let (mut flat, mut rise) = (across(c.velocity, up), c.velocity.dot(up));
    (c.on_steep, c.hit_ceiling) = (out.on_steep, out.hit_ceiling);
    (c.squeezed, c.stepped) = (out.squeezed, out.stepped);
    if out.hit_ceiling {
        rise = f32s::min(rise, 0.0);
    }
    // Walls take what goes into them, of which what gives way leaves as much as it goes itself; what walks on is asked for again in every
    // step.
    for h in &c.hits {
        if let Some((n, _)) = across(h.normal, up).try_normalize()
            && h.normal.dot(up) < c.desc.mover.cos_slope()
        {
            let away = f32s::min(velocity_at(world, h).dot(n), 0.0);
            flat += n * f32s::max(away - flat.dot(n), 0.0);
        }
    }
    match out.ground {
        Some(g) => {
            if c.ground.is_none() {
                flat -= across(g.velocity, up);
            }
            (rise, c.air_time) = (0.0, 0.0);
        }
        None => {
            if c.ground.is_some() {
                flat += across(carried, up);
                rise = f32s::max(carried.dot(up), 0.0);
            } else if out.on_steep && rise < 0.0 {
                // Down a slope: what the fall became along it.
                flat += across(out.fell, up) * (1.0 / dt);
                rise = f32s::min(out.fell.dot(up) / dt, 0.0);
            }
            c.air_time += dt;
        }
    }
    c.velocity = flat + up * rise;
    (c.foot, c.ground) = (out.foot, out.ground);
}

/// Of the point of a dynamic body that was hit.
fn velocity_at(world: &World, h: &CharacterHit) -> Vec3 {
    let Ok(slot) = world.slot(h.body) else { return Vec3::ZERO };
    let body = &world.bodies[slot];
    if body.kind != BodyKind::Dynamic {
        return Vec3::ZERO;
    }
    let (v, w) = world.velocities(body);
    v + w.cross((h.point - world.frames[slot as usize].center).as_vec3())
}

/// Forces on what is in the way.
fn push(world: &mut World, c: &Character, step: &Step) {
    let up = c.desc.mover.up;
    let ground = c.ground.map_or(Vec3::ZERO, |g| g.velocity);
    let wanted = across(c.input.walk, up) + across(ground, up);
    let wanted = if c.ground.is_some() { wanted } else { across(c.velocity, up) + wanted };
    for (i, h) in c.hits.iter().enumerate() {
        let stands = c.ground.is_some_and(|g| g.body == h.body);
        if !stands
            && c.hits[..i].iter().all(|o| o.body != h.body)
            && let Some((at, j)) = world.push_of(h, up, wanted, c.desc.push_force * step.dt)
        {
            // Over the step, as friction is: at once, what friction holds would slip a little in every step.
            let _ = world.do_force(h.body, j * (1.0 / step.dt), Vec3::ZERO, Some(at));
        }
    }
}

/// The weight of a walker on what it stands on, F ≤ M g.
///
/// One that falls with its ground weighs less: g − F/M is what it falls with itself, and under F the ground went with a; where that is faster,
/// its feet would leave it. F goes by what the two differ in, (g − F/M − a)/(1/M + w), w the inverse mass of the ground there: on what stands that
/// ends at M g, at once on what is heavy, over some steps on what is light; what falls freely under it gets what the two fall with together, g/(1/M + w).
fn bear(world: &mut World, c: &mut Character, stood: Option<CharacterGround>, dt: f32, moved: bool) {
    let Some(g) = c.ground else {
        c.load = 0.0;
        return;
    };
    let (up, mass) = (c.desc.mover.up, c.desc.mass);
    let fall = f32s::max(-world.gravity.dot(up), 0.0) * c.desc.gravity_scale;
    let give = world.slot(g.body).map_or(0.0, |slot| {
        world.give_of(slot, (g.point - world.frames[slot as usize].center).as_vec3(), up)
    });
    let before = stood.filter(|s| s.body == g.body);
    if before.is_none() {
        c.load = 0.0;
    }
    let sinks = f32s::max(before.map_or(0.0, |s| (s.velocity - g.velocity).dot(up) / dt), 0.0);
    let change = mass * (fall - sinks - c.load / f32s::max(mass, f32::MIN_POSITIVE)) / (1.0 + mass * give);
    c.load = f32s::clamp(c.load + change, 0.0, mass * f32s::max(fall, 0.0));
    weigh(world, &g, up * -c.load, moved);
}

/// A force on what carries a character, while that is awake or the character moves; a sleeper bears one that stands already.
fn weigh(world: &mut World, g: &CharacterGround, force: Vec3, moved: bool) {
    let Ok(slot) = world.slot(g.body) else { return };
    let body = &world.bodies[slot];
    if body.kind == BodyKind::Dynamic && (moved || body.row != NONE) {
        let _ = world.do_force(g.body, force, Vec3::ZERO, Some(g.point));
    }
}

/// Most that a step's weight changes the velocity of where a dynamic character stands, m/s: what is much lighter bears no more before its
/// contacts answer.
const KICK: f32 = 3.0;

/// The part of a force that it bears.
fn borne(world: &World, g: &CharacterGround, force: Vec3, dt: f32) -> f32 {
    let Ok(slot) = world.slot(g.body) else { return 0.0 };
    let lever = (g.point - world.frames[slot as usize].center).as_vec3();
    let kick = force.try_normalize().map_or(0.0, |(n, size)| size * dt * world.give_of(slot, lever, n));
    f32s::min(1.0, KICK * world.settings.length_unit / f32s::max(kick, f32::MIN_POSITIVE))
}

/// Rise against the way of the steepest slope on which a character goes up or down, and does not step.
const SLOPE: f32 = 1.2;

/// Makes the new place the target of the body, and lets later characters see it. `carried`: how far its ground took it up, m.
fn lead(world: &mut World, c: &Character, carried: f32, ahead: &mut Vec<Ahead>) {
    let from = world.frames[c.body as usize].pose();
    let to = WorldPose::new(c.foot, c.desc.rotation(c.heading));
    let still = (to.p - from.p).length() < 1e-9 && (to.q == from.q || to.q.dot(from.q).abs() > 1.0 - 1e-7);
    if still {
        return;
    }
    let id = world.body_id(c.body);
    // Up and down steps it goes at once: on the way, its velocity would kick what it steps on.
    let (way, up) = ((to.p - from.p).as_vec3(), c.desc.mover.up);
    let usual = SLOPE * across(way, up).length() + carried.abs() + c.desc.mover.skin;
    let step = way.dot(up) - f32s::clamp(way.dot(up), -usual, usual);
    if c.ground.is_some() && step != 0.0 {
        let _ = world.do_teleport(id, from.p + (up * step).as_dvec3(), from.q);
    }
    if world.do_move_to(id, to.p, to.q).is_ok() {
        let at = ahead.partition_point(|a| a.body < c.body);
        let mine = Ahead { body: c.body, from, to };
        match ahead.get_mut(at) {
            Some(a) if a.body == c.body => *a = mine,
            _ => ahead.insert(at, mine),
        }
    }
}

/// A dynamic character: leg and walking as forces.
fn stand(world: &mut World, c: &mut Character, ahead: &[Ahead], scratch: &mut MoveScratch, step: &Step) {
    begin(world, c);
    crouch(world, c, ahead, scratch, step.dt);
    c.foot = world.frames[c.body as usize].pose().p;
    let (dt, up, m) = (step.dt, c.desc.mover.up, c.desc.mover);
    let id = world.body_id(c.body);
    let (v, _) = world.velocities(&world.bodies[c.body]);
    if let Some(j) = c.input.jump.take() {
        let rise = f32s::max(c.ground.map_or(0.0, |g| g.velocity.dot(up)), 0.0) + j;
        let _ = world.do_set_velocity(id, Some(across(v, up) + up * rise), None);
        (c.ground, c.air_time) = (None, 0.0);
    }
    let (v, _) = world.velocities(&world.bodies[c.body]);
    let filter = QueryFilter::default();
    let mut hits = core::mem::take(&mut c.hits);
    let mut a = around(world, &m, c, ahead, scratch, &filter, dt);
    // The ground as it stands: forces act on bodies where they are.
    a.part = 0.0;
    a.look(c.foot, m.step_height + m.snap + 8.0 * m.skin);
    if a.ignored != NONE && !a.is_near(a.ignored, c.foot, 2.0 * m.skin) {
        (c.passing, a.ignored) = (None, NONE);
    }
    let leaving = v.dot(up) > 0.5 && c.ground.is_none();
    // From as high as the capsule is: what is above its bottom is a wall.
    let above = f32s::min(m.step_height, c.height() - 2.0 * m.radius);
    let reach = above + if c.ground.is_some() { m.snap } else { m.skin };
    (a.height, a.capsule) = (c.height() - above, m.capsule(c.height() - above));
    let high = c.foot + (up * above).as_dvec3();
    let walk = Walk::new(&mut a, &mut hits, high);
    let hit = if leaving { None } else { walk.down(reach) };
    let (ground, steep) = match hit {
        Some((h, true)) => (Some((walk.ground_of(&h), leg::height_over(&h, above))), None),
        Some((h, false)) => (None, Some(h.normal)),
        None => (None, None),
    };
    c.hits = hits;
    let carrier = ground.and_then(|g| Some((world.slot(g.0.body).ok()?, g.0.point)));
    let give = |n: Vec3| {
        carrier.map_or(0.0, |(slot, point)| {
            world.give_of(slot, (point - world.frames[slot as usize].center).as_vec3(), n)
        })
    };
    let s = Stand {
        desc: &c.desc,
        up,
        gravity: world.gravity * c.desc.gravity_scale,
        dt,
        velocity: v,
        ground_velocity: ground.map_or(Vec3::ZERO, |g| g.0.velocity),
        walk: c.input.walk,
        height: ground.map(|g| g.1),
        steep,
        give: &give,
    };
    let force = leg::force(&s);
    let _ = world.do_force(id, force, Vec3::ZERO, None);
    if let Some((g, _)) = &ground {
        // One that has just landed, or walks, wakes a sleeper.
        let stirs = c.air_time > 0.0 || v.length() > world.settings.sleep_speed;
        let part = borne(world, g, force, dt);
        weigh(world, g, force * -part, stirs);
    }
    c.on_steep = steep.is_some();
    c.air_time = if ground.is_some() { 0.0 } else { c.air_time + dt };
    c.ground = ground.map(|g| g.0);
    c.velocity = v - c.ground.map_or(Vec3::ZERO, |g| g.velocity);
    if c.desc.turns_with_ground
        && let Some((g, _)) = &ground
        && let Ok(slot) = world.slot(g.body)
    {
        let turn = world.velocities(&world.bodies[slot]).1.dot(up) * dt;
        c.heading += turn;
    }
}
