//! What a character sees of the world: the shapes near it, where moving ones will be at the end of the step.

use super::desc::CharacterMover;
use super::planes::{PLANES_MAX, Plane};
use crate::edit::world_bounds;
use crate::limits;
use crate::query::QueryFilter;
use crate::room::contacts::desc::Filter;
use crate::room::rigid::desc::BodyKind;
use crate::room::rigid::state::NONE;
use crate::world::World;
use jounce_geometry::{Aabb, ManifoldSet, PairCache, Shape, cast_shape, collide, distance};
use jounce_math::{DVec3, Quat, Vec3, WorldPose, scalar::f32s};

/// Where a body will be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead {
    pub body: u32,
    pub from: WorldPose,
    pub to: WorldPose,
}

/// Memory that is reused from move to move and is not state.
#[derive(Debug, Default)]
pub(crate) struct MoveScratch {
    pub near: Vec<u32>,
    pub set: ManifoldSet,
    found: Vec<(Plane, DVec3)>,
    movers: Vec<([f32; 2], u32)>,
    /// Most shapes near a character, and most planes weighed against one another, so far: for tests.
    #[cfg(test)]
    pub most_near: usize,
    #[cfg(test)]
    pub most_planes: usize,
}

impl Clone for MoveScratch {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// Who moves, against what.
pub(crate) struct Around<'a> {
    pub world: &'a World,
    pub mover: &'a CharacterMover,
    pub up: Vec3,
    /// Height from foot to crown, now.
    pub height: f32,
    pub capsule: Shape,
    /// +Y to up.
    pub turn: Quat,
    /// Own body, or NONE.
    pub body: u32,
    pub own: Filter,
    pub filter: &'a QueryFilter<'a>,
    /// Sorted by body.
    pub ahead: &'a [Ahead],
    /// How far of that way, 0…1.
    pub part: f32,
    /// A shape that is passed through.
    pub ignored: u32,
    /// How a body that comes on is slowed: push force × Δt, N s; and the own mass, kg, and the step, s.
    pub resist: [f32; 3],
    pub scratch: &'a mut MoveScratch,
}

/// What a sweep meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub shape: u32,
    /// How far it may go, m; the skin is kept.
    pub go: f32,
    pub point: DVec3,
    /// Towards the character.
    pub normal: Vec3,
}

/// Looks this much farther than it goes, in skins.
const LOOK_AHEAD: f32 = 4.0;
/// Least cosine of a hit that the skin is measured by.
const GRAZING: f32 = 0.25;

impl Around<'_> {
    /// Pose of the capsule over a foot point.
    pub fn pose(&self, foot: DVec3) -> WorldPose {
        WorldPose::new(foot + (self.up * (0.5 * self.height)).as_dvec3(), self.turn)
    }

    /// Looks up the shapes that a move from `foot` by at most `reach` metres can meet. Of what can move only the nearest
    /// [`limits::CHARACTER_MOVERS_MAX`] count, so that a character's work has a bound in any crowd.
    pub fn look(&mut self, foot: DVec3, reach: f32) {
        let fastest = self.ahead.iter().fold(0.0, |m, a| {
            let turn = (a.to.q * a.from.q.conjugate()).xyz().length() * 2.0;
            f32s::max(m, (a.to.p - a.from.p).as_vec3().length() + turn * self.reach_of(a, foot))
        });
        let own = world_bounds(&self.capsule, &self.pose(foot));
        let reached = own.expanded(reach);
        let box_ = reached.expanded(fastest);
        let mut near = core::mem::take(&mut self.scratch.near);
        let mut movers = core::mem::take(&mut self.scratch.movers);
        near.clear();
        movers.clear();
        let world = self.world;
        let mut see = |s: u32| {
            if near.len() < limits::CHARACTER_SHAPES_MAX && self.meets(s) {
                near.push(s);
            }
            true
        };
        for &s in &world.unbounded {
            see(s);
        }
        world.fixed_tree.query(&box_, &mut see);
        world.moving_tree.get().query(&box_, |s| {
            if self.meets(s) && self.comes_within(s, &reached) {
                match self.distance_to(s, &own) {
                    Some(d) => movers.push((d, s)),
                    None => near.push(s),
                }
            }
            movers.len() + near.len() < limits::CHARACTER_SHAPES_MAX
        });
        let most = limits::CHARACTER_MOVERS_MAX;
        if movers.len() > most {
            movers.select_nth_unstable_by(most, |(a, i), (b, j)| {
                a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(i.cmp(j))
            });
            movers.truncate(most);
        }
        near.extend(movers.iter().map(|m| m.1));
        near.sort_unstable();
        #[cfg(test)]
        {
            self.scratch.most_near = self.scratch.most_near.max(near.len());
        }
        (self.scratch.near, self.scratch.movers) = (near, movers);
    }

    /// Is any of a shape's way of this step in a box? Where its body turns, the way is not known.
    fn comes_within(&self, s: u32, box_: &Aabb) -> bool {
        let r = &self.world.shapes[s];
        let Some(a) = self.ahead_of(r.body) else { return true };
        if a.from.q != a.to.q {
            return true;
        }
        let at = |p: &WorldPose| world_bounds(&r.shape, &p.compose(&r.pose));
        at(&a.from).union(&at(&a.to)).overlaps(box_)
    }

    /// How far a shape will be from a box, and their middles from one another, both squared; none of what is large against the
    /// character: that may be ground, and is never left out.
    fn distance_to(&self, s: u32, box_: &Aabb) -> Option<[f32; 2]> {
        let r = &self.world.shapes[s];
        let b = match self.ahead_of(r.body) {
            Some(a) => world_bounds(&r.shape, &a.to.compose(&r.pose)),
            None => self.world.fat[s as usize],
        };
        if (b.max - b.min).max_component() > 2.0 * self.height {
            return None;
        }
        let gap = (b.min - box_.max).max(box_.min - b.max).max(Vec3::ZERO);
        Some([gap.length_squared(), (b.center() - box_.center()).length_squared()])
    }

    /// Lever by which a turn of a body moves what is near a foot.
    fn reach_of(&self, a: &Ahead, foot: DVec3) -> f32 {
        let lever = (foot - a.from.p).as_vec3().length() + self.height;
        f32s::min(lever, 2.0 * self.world.bodies[a.body].mass.outer_radius)
    }

    /// Does it collide with this shape at all?
    fn meets(&self, s: u32) -> bool {
        let r = &self.world.shapes[s];
        !r.sensor && r.body != self.body && r.filter.allows(&self.own) && self.world.sees(s, self.filter)
    }

    pub fn one_way(&self, s: u32) -> bool {
        self.world.shapes[s].filter.layers & self.mover.one_way_layers != 0
    }

    fn ahead_of(&self, body: u32) -> Option<&Ahead> {
        self.ahead.binary_search_by_key(&body, |a| a.body).ok().map(|i| &self.ahead[i])
    }

    /// Longest way in this step of what is near, m.
    pub fn fastest_near(&self) -> f32 {
        let way = |s: &u32| {
            let a = self.ahead_of(self.world.shapes[*s].body)?;
            Some((a.to.p - a.from.p).as_vec3().length())
        };
        self.scratch.near.iter().filter_map(way).fold(0.0, f32s::max)
    }

    /// A shape's frame, where its body will be.
    pub fn place(&self, s: u32) -> WorldPose {
        let r = &self.world.shapes[s];
        match self.ahead_of(r.body) {
            None => self.world.pose_of(r),
            Some(a) if self.part >= 1.0 => a.to.compose(&r.pose),
            Some(a) => {
                let p = a.from.p.lerp(a.to.p, f64::from(self.part));
                WorldPose::new(p, a.from.q.nlerp(a.to.q, self.part)).compose(&r.pose)
            }
        }
    }

    /// Where a point that is fixed to a body now will be, seen from where it is.
    pub fn carried(&self, body: u32, point: DVec3) -> Vec3 {
        let Some(a) = self.ahead_of(body) else { return Vec3::ZERO };
        (a.to.transform_point(a.from.inverse_transform_point(point)) - point).as_vec3()
    }
    /// Turn of a body about up, rad.
    pub fn turned(&self, body: u32) -> f32 {
        let Some(a) = self.ahead_of(body) else { return 0.0 };
        let d = a.to.q * a.from.q.conjugate();
        let sign = if d.w < 0.0 { -1.0 } else { 1.0 };
        2.0 * f32s::atan2(sign * d.xyz().dot(self.up), sign * d.w)
    }

    /// Steps in a second.
    pub fn per_second(&self) -> f32 {
        1.0 / self.resist[2]
    }

    /// Do a shape's bounds meet a box at all?
    fn may_touch(&self, s: u32, bounds: &Aabb) -> bool {
        let r = &self.world.shapes[s];
        if matches!(r.shape, Shape::HalfSpace { .. }) {
            return true;
        }
        match self.ahead_of(r.body) {
            Some(_) => world_bounds(&r.shape, &self.place(s)).overlaps(bounds),
            None => self.world.fat[s as usize].overlaps(bounds),
        }
    }

    /// The first shape in the way from `foot` along `motion`; the lowest slot of equals. `blocks` says which count, given slot and
    /// normal.
    pub fn cast(&self, foot: DVec3, motion: Vec3, blocks: impl Fn(u32, Vec3) -> bool) -> Option<Hit> {
        let (dir, length) = motion.try_normalize()?;
        let skin = self.mover.skin;
        let sweep = dir * (length + LOOK_AHEAD * skin);
        let at = self.pose(foot);
        let start = world_bounds(&self.capsule, &at);
        let bounds = start.union(&Aabb::new(start.min + sweep, start.max + sweep)).expanded(skin);
        let mut best: Option<Hit> = None;
        for &s in &self.scratch.near {
            if s == self.ignored || !self.may_touch(s, &bounds) {
                continue;
            }
            let place = self.place(s);
            let along = place.q.inverse_rotate(sweep);
            let Some(h) = cast_shape(&self.world.shapes[s].shape, &self.capsule, &place.relative(&at), along)
            else {
                continue;
            };
            let normal = place.q.rotate(h.normal);
            let cosine = -normal.dot(dir);
            // It overlaps already, and this way leads out.
            if cosine <= 0.0 || !blocks(s, normal) {
                continue;
            }
            let go = h.t * sweep.length() - skin / f32s::max(cosine, GRAZING);
            if go < length && best.is_none_or(|b| go < b.go) {
                best = Some(Hit { shape: s, go, point: place.transform_point(h.point), normal });
            }
        }
        best.map(|b| Hit { go: f32s::max(b.go, 0.0), ..b })
    }

    /// The normal of the surface under a point, looked for with a small ball from `above` metres over it.
    pub fn face_under(&self, point: DVec3, above: f32, below: f32) -> Option<Vec3> {
        let ball = Shape::Sphere { radius: 0.05 * self.mover.skin };
        let at = WorldPose::new(point + (self.up * above).as_dvec3(), Quat::IDENTITY);
        let sweep = -self.up * (above + below);
        let start = world_bounds(&ball, &at);
        let bounds = start.union(&Aabb::new(start.min + sweep, start.max + sweep)).expanded(self.mover.skin);
        let mut best: Option<(f32, Vec3)> = None;
        for &s in &self.scratch.near {
            if s == self.ignored || !self.may_touch(s, &bounds) {
                continue;
            }
            let place = self.place(s);
            let along = place.q.inverse_rotate(sweep);
            if let Some(h) = cast_shape(&self.world.shapes[s].shape, &ball, &place.relative(&at), along)
                && best.is_none_or(|b| h.t < b.0)
            {
                best = Some((h.t, place.q.rotate(h.normal)));
            }
        }
        best.filter(|b| b.0 > 0.0).map(|b| b.1)
    }

    /// Does the capsule at `foot`, with `shrink` of its radius taken off, overlap anything?
    pub fn overlaps(&self, foot: DVec3, shrink: f32) -> bool {
        let Shape::Capsule { half_height, radius } = self.capsule else { return false };
        let thin = Shape::Capsule { half_height, radius: radius - shrink };
        let at = self.pose(foot);
        let bounds = world_bounds(&thin, &at);
        self.scratch.near.iter().any(|&s| {
            s != self.ignored
                && !self.one_way(s)
                && self.may_touch(s, &bounds)
                && distance(&self.world.shapes[s].shape, &thin, &self.place(s).relative(&at), 0.0).is_some()
        })
    }
    /// Is the capsule within a distance of a shape?
    pub fn is_near(&self, s: u32, foot: DVec3, reach: f32) -> bool {
        let shape = &self.world.shapes[s].shape;
        distance(shape, &self.capsule, &self.place(s).relative(&self.pose(foot)), reach).is_some()
    }

    /// How far a dynamic body may come in a step.
    fn comes_on(&self, body: u32) -> f32 {
        let b = &self.world.bodies[body];
        if b.kind != BodyKind::Dynamic || b.row == NONE || self.resist[1] <= 0.0 {
            return 0.0;
        }
        let (v, w) = self.world.velocities(b);
        (v.length() + w.length() * b.mass.outer_radius) * self.resist[2]
    }

    /// Speed at which a dynamic body still comes on along n after the character withstood it; see the room's text.
    fn yields(&self, body: u32, point: DVec3, n: Vec3) -> f32 {
        let b = &self.world.bodies[body];
        let [impulse, mass, _] = self.resist;
        if b.kind != BodyKind::Dynamic || b.row == NONE || mass <= 0.0 || b.mass.mass <= 0.0 {
            return 0.0;
        }
        let (v, w) = self.world.velocities(b);
        let lever = (point - self.world.frames[body as usize].center).as_vec3();
        let speed = (v + w.cross(lever)).dot(n);
        let share = f32s::min(b.mass.mass / mass, 1.0);
        f32s::max(speed * share - impulse / b.mass.mass, 0.0)
    }

    /// Planes of all that is near, if any of it is nearer than the skin: how far to go along each normal (negative where there is
    /// room). One-way platforms are left out.
    pub fn planes(&mut self, foot: DVec3, out: &mut [Plane; PLANES_MAX]) -> usize {
        let skin = self.mover.skin;
        let at = self.pose(foot);
        let bounds = world_bounds(&self.capsule, &at).expanded(2.0 * skin);
        let mut found = core::mem::take(&mut self.scratch.found);
        let mut set = core::mem::take(&mut self.scratch.set);
        found.clear();
        for &s in &self.scratch.near {
            let r = &self.world.shapes[s];
            let near = bounds.expanded(self.comes_on(r.body));
            if s == self.ignored || self.one_way(s) || !self.may_touch(s, &near) {
                continue;
            }
            let place = self.place(s);
            let pose = place.relative(&at);
            // A body that comes on is seen a step ahead.
            let margin = 2.0 * skin + self.comes_on(r.body);
            collide(&r.shape, &self.capsule, &pose, margin, &mut PairCache::default(), &mut set);
            for m in &set.manifolds {
                let n = place.q.rotate(m.normal);
                let Some(p) = m.points().iter().min_by(|a, b| a.separation.total_cmp(&b.separation)) else {
                    continue;
                };
                let surface = m.normal * (-0.5 * p.separation) + p.point;
                let point = place.transform_point(surface);
                let give = self.yields(r.body, point, n) * self.resist[2];
                found.push((Plane { n, least: skin - p.separation + give }, point));
            }
        }
        // A gap that is right but for the last few percent stays: what stands still stays still.
        let needed = found.iter().any(|f| f.0.least > 0.05 * skin);
        found.sort_by(|a, b| b.0.least.total_cmp(&a.0.least));
        found.truncate(limits::CHARACTER_PLANES_MAX);
        #[cfg(test)]
        {
            self.scratch.most_planes = self.scratch.most_planes.max(found.len());
        }
        let n = if needed { keep_needed(&found, 0.05 * skin, out) } else { 0 };
        (self.scratch.found, self.scratch.set) = (found, set);
        n
    }
}

/// Drops the planes of points that lie on the surface of a deeper one: whoever keeps his distance from a flat floor keeps it from
/// every edge between its tiles. The deepest come first.
fn keep_needed(found: &[(Plane, DVec3)], slop: f32, out: &mut [Plane; PLANES_MAX]) -> usize {
    let mut n = 0;
    for (i, (plane, point)) in found.iter().enumerate() {
        let on = |(p, q): &(Plane, DVec3)| {
            plane.n.dot(p.n) > 0.0 && (*point - *q).as_vec3().dot(p.n).abs() <= slop
        };
        if n == PLANES_MAX {
            break;
        }
        if !found[..i].iter().any(on) {
            out[n] = *plane;
            n += 1;
        }
    }
    n
}
