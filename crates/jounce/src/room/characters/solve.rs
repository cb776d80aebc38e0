//! One move: push out, across, step up, along up. Symbols as in the room's text.

use super::around::{Around, Hit};
use super::desc::{CharacterGround, CharacterHit};
use super::planes::{PLANES_MAX, Plane, nearest};
use crate::limits;
use crate::room::rigid::desc::BodyKind;
use jounce_math::{DVec3, Vec3, scalar::f32s};

/// Rounds of sliding.
const SLIDES: usize = 6;
/// Rounds of pushing out.
const PUSHES: usize = 4;
/// Least way across that a step up makes, in skins: it comes to stand over the edge, not beside it.
const STEP_ON: f32 = 4.0;
/// An edge carries a foot whose axis is within this part of the radius of it.
const EDGE: f32 = 0.8;
/// Where the face behind an edge is looked for, in skins from the edge, and from how high above it, in skins.
const BEHIND: f32 = 2.0;
const ABOVE: f32 = 3.0;
/// Cosine to up below which an edge is beside, not below.
const WALL: f32 = 0.1;
/// Cosine to up below which a surface overhangs.
const CEILING: f32 = -0.05;

/// What a move asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wish {
    /// Way across up, m.
    pub across: Vec3,
    /// Way along up, m.
    pub rise: f32,
    /// Stands on the ground, and means to stay on it.
    pub grounded: Option<Vec3>,
}

/// What came of it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    pub foot: DVec3,
    pub ground: Option<CharacterGround>,
    pub on_steep: bool,
    /// The way down, and along what was too steep, m.
    pub fell: Vec3,
    pub hit_ceiling: bool,
    pub stepped: f32,
    pub squeezed: bool,
}

/// The part of a vector across up.
pub(crate) fn across(v: Vec3, up: Vec3) -> Vec3 {
    v - up * v.dot(up)
}

/// A way across, turned along ground with this normal; as long as it was.
fn along_ground(way: Vec3, n: Vec3, up: Vec3) -> Vec3 {
    let t = way - up * (way.dot(n) / f32s::max(n.dot(up), 1e-3));
    t.normalize_or(Vec3::ZERO) * way.length()
}

/// A move in the making.
pub(crate) struct Walk<'a, 'b> {
    pub around: &'a mut Around<'b>,
    pub hits: &'a mut Vec<CharacterHit>,
    pub out: Outcome,
    cos_slope: f32,
    /// Direction it wants to go, across up.
    wanted: Vec3,
}

impl<'a, 'b> Walk<'a, 'b> {
    pub fn new(around: &'a mut Around<'b>, hits: &'a mut Vec<CharacterHit>, foot: DVec3) -> Self {
        let cos_slope = around.mover.cos_slope();
        let out = Outcome { foot, ..Outcome::default() };
        Self { around, hits, out, cos_slope, wanted: Vec3::ZERO }
    }

    /// Away from all that is nearer than the skin.
    pub fn push_out(&mut self) {
        let mut planes = [Plane::default(); PLANES_MAX];
        for _ in 0..PUSHES {
            let n = self.around.planes(self.out.foot, &mut planes);
            if n == 0 {
                self.out.squeezed = false;
                return;
            }
            let (way, bad) = nearest(Vec3::ZERO, &planes[..n]);
            // The gap is gone, not only smaller.
            self.out.squeezed = bad > self.around.mover.skin;
            // Planes that contradict each other meet far away, where nobody should be in a moment.
            let most = 2.0 * planes[0].least + self.around.mover.radius;
            let length = way.length();
            let way = if length > most { way * (most / length) } else { way };
            self.out.foot += way.as_dvec3();
        }
    }

    /// The whole move.
    pub fn go(&mut self, wish: &Wish) {
        let up = self.around.up;
        self.wanted = across(wish.across, up);
        let start = self.out.foot;
        self.push_out();
        self.slide(self.wanted, wish.grounded);
        if wish.rise > 0.0 {
            self.rise(wish.rise);
        } else if wish.grounded.is_some() {
            self.snap();
        } else {
            self.fall(-wish.rise);
        }
        debug_assert!((self.out.foot - start).is_finite(), "a move of finite size");
    }

    fn note(&mut self, h: &Hit) {
        if self.hits.len() < limits::CHARACTER_HITS_MAX {
            let w = self.around.world;
            self.hits.push(CharacterHit {
                body: w.body_id(w.shapes[h.shape].body),
                shape: w.shape_id(h.shape),
                point: h.point,
                normal: h.normal,
            });
        }
    }

    /// Everything but platforms that only carry from above.
    fn cast(&self, motion: Vec3) -> Option<Hit> {
        self.cast_from(self.out.foot, motion)
    }
    fn cast_from(&self, foot: DVec3, motion: Vec3) -> Option<Hit> {
        self.around.cast(foot, motion, |s, _| !self.around.one_way(s))
    }
    /// Downwards: those platforms too, where it is above them.
    fn cast_down(&self, foot: DVec3, way: f32) -> Option<Hit> {
        let a = &self.around;
        a.cast(foot, -a.up * way, |s, n| {
            !a.one_way(s) || (n.dot(a.up) >= self.cos_slope && !a.is_near(s, foot, 0.0))
        })
    }

    fn walkable(&self, n: Vec3) -> bool {
        n.dot(self.around.up) >= self.cos_slope
    }

    /// Does what was hit carry the character? An edge does if the face behind it may be walked on and the foot is over it, or is
    /// on its way there.
    fn carries(&self, foot: DVec3, h: &Hit) -> bool {
        if self.walkable(h.normal) {
            return true;
        }
        let (up, m) = (self.around.up, self.around.mover);
        let lean = across(h.normal, up);
        if h.normal.dot(up) <= WALL || !self.face_behind(h).is_some_and(|n| self.walkable(n)) {
            return false;
        }
        let off = across((foot - h.point).as_vec3(), up).length();
        if off <= EDGE * m.radius || self.wanted.dot(lean) < 0.0 {
            return true;
        }
        // Off the edge of a step it goes down on the next one's ground, not through the air.
        let below = self.around.face_under(foot, m.skin, f32s::max(m.snap, 2.0 * m.skin));
        below.is_some_and(|n| self.walkable(n))
    }

    /// Normal of the face behind an edge.
    fn face_behind(&self, h: &Hit) -> Option<Vec3> {
        let skin = self.around.mover.skin;
        let back = across(h.normal, self.around.up).normalize_or(Vec3::ZERO) * (-BEHIND * skin);
        self.around.face_under(h.point + back.as_dvec3(), ABOVE * skin, 2.0 * ABOVE * skin)
    }

    /// Across up: sweeps, and turns along what it hits.
    fn slide(&mut self, way: Vec3, grounded: Option<Vec3>) {
        let up = self.around.up;
        let least = 1e-3 * self.around.mover.skin;
        let (mut rest, mut floor, mut may_step) = (way, grounded, grounded.is_some());
        let mut planes = [Plane::default(); PLANES_MAX];
        let mut n = 0;
        for _ in 0..SLIDES {
            let want = floor.map_or(rest, |f| along_ground(rest, f, up));
            let mut all = planes;
            let mut count = n;
            if let Some(f) = floor {
                all[count] = Plane { n: f, least: 0.0 };
                count += 1;
            }
            let (d, _) = nearest(want, &all[..count]);
            if d.length() < least || d.dot(way) <= 0.0 {
                return;
            }
            let Some(h) = self.cast(d) else {
                self.out.foot += d.as_dvec3();
                return;
            };
            let length = d.length();
            self.out.foot += (d * (h.go / length)).as_dvec3();
            rest = across(d, up) * (1.0 - h.go / length);
            if self.walkable(h.normal) {
                // Twice the same: an edge that turns the way neither along nor over itself.
                if floor.is_some_and(|f| f.dot(h.normal) > 0.9999) {
                    return;
                }
                if floor.is_some() {
                    floor = Some(h.normal);
                    continue;
                }
            } else if may_step && self.step_up(rest, &h) {
                may_step = false;
                (floor, n) = (Some(up), 0);
                rest = Vec3::ZERO;
                continue;
            }
            self.note(&h);
            let flat = across(h.normal, up);
            let normal = if self.walkable(h.normal) || (floor.is_none() && h.normal.dot(up) < CEILING) {
                h.normal
            } else {
                flat.normalize_or(-rest.normalize_or(up))
            };
            if n + 1 < PLANES_MAX {
                planes[n] = Plane { n: normal, least: 0.0 };
                n += 1;
            }
        }
    }

    /// Up, on, down. Kept where it ends higher, on ground that carries.
    fn step_up(&mut self, rest: Vec3, wall: &Hit) -> bool {
        let (up, m) = (self.around.up, *self.around.mover);
        if m.step_height <= 0.0 {
            return false;
        }
        // A body that can be pushed away is pushed, not climbed, unless it is low.
        let dir = rest.normalize_or(across(-wall.normal, up).normalize_or(Vec3::ZERO));
        let start = self.out.foot;
        let lift = m.step_height + 0.5 * m.skin;
        let a = self.cast_from(start, up * lift).map_or(lift, |h| h.go);
        let high = start + (up * a).as_dvec3();
        let on = f32s::max(rest.length(), STEP_ON * m.skin);
        let b = self.cast_from(high, dir * on).map_or(on, |h| h.go);
        if a <= m.skin || b < 0.5 * STEP_ON * m.skin {
            return false;
        }
        let over = high + (dir * b).as_dvec3();
        let Some(h) = self.cast_down(over, a + m.skin) else { return false };
        let foot = over - (up * h.go).as_dvec3();
        let gained = a - h.go;
        // The edge itself is no higher than a step, measured from the ground a skin below the foot.
        let height = (h.point - start).as_vec3().dot(up) + m.skin;
        let low = height <= m.step_height + 0.5 * m.skin;
        if gained <= 0.1 * m.skin || !low || !(self.walkable(h.normal) || self.stands_on(&h)) {
            return false;
        }
        (self.out.foot, self.out.stepped) = (foot, self.out.stepped + gained);
        true
    }

    /// Is the top of the step ground to walk on, whatever the edge's normal?
    fn stands_on(&self, h: &Hit) -> bool {
        h.normal.dot(self.around.up) > 0.0 && self.face_behind(h).is_some_and(|n| self.walkable(n))
    }

    /// Up until a ceiling; along it where it slopes.
    fn rise(&mut self, way: f32) {
        let up = self.around.up;
        let mut planes = [Plane::default(); PLANES_MAX];
        let (mut n, mut d) = (0, up * way);
        for _ in 0..SLIDES {
            let Some(h) = self.cast(d) else {
                self.out.foot += d.as_dvec3();
                return;
            };
            let length = d.length();
            self.out.foot += (d * (h.go / length)).as_dvec3();
            self.note(&h);
            self.out.hit_ceiling |= h.normal.dot(up) < CEILING;
            (planes[n], n) = (Plane { n: h.normal, least: 0.0 }, n + 1);
            d = nearest(d * (1.0 - h.go / length), &planes[..n]).0;
            if d.length() < 1e-3 * self.around.mover.skin || d.dot(up) <= 0.0 {
                return;
            }
        }
    }

    /// Down, sliding along what is too steep, until something carries.
    fn fall(&mut self, way: f32) {
        let (up, skin) = (self.around.up, self.around.mover.skin);
        let mut planes = [Plane::default(); PLANES_MAX];
        // Even at the top of a jump a little look-out finds the ground.
        let (mut n, mut d) = (0, -up * f32s::max(way, 0.1 * skin));
        let start = self.out.foot;
        for _ in 0..SLIDES {
            let down = across(d, up).length_squared() < 1e-12 * d.length_squared();
            let hit = if down { self.cast_down(self.out.foot, d.length()) } else { self.cast(d) };
            let length = d.length();
            let go = hit.map_or(1.0, |h| h.go / length);
            self.out.foot += (d * go).as_dvec3();
            self.out.fell = (self.out.foot - start).as_vec3();
            let Some(h) = hit else { return };
            if self.carries(self.out.foot, &h) {
                return self.land(&h);
            }
            self.out.on_steep |= h.normal.dot(up) > 0.0;
            self.note(&h);
            (planes[n], n) = (Plane { n: h.normal, least: 0.0 }, n + 1);
            d = nearest(d * (1.0 - go), &planes[..n]).0;
            if d.length() < 1e-3 * skin || d.dot(up) >= 0.0 {
                return;
            }
        }
    }

    /// Down onto the ground, if it is near enough.
    fn snap(&mut self) {
        let (up, m) = (self.around.up, self.around.mover);
        let reach = f32s::max(m.snap, 2.0 * m.skin);
        let Some(h) = self.cast_down(self.out.foot, reach) else { return };
        let foot = self.out.foot - (up * h.go).as_dvec3();
        if !self.carries(foot, &h) {
            self.out.on_steep |= h.normal.dot(up) > 0.0;
            return;
        }
        // What stands stays: a gap that is right but for the last percents is not mended.
        if h.go > 0.05 * m.skin {
            self.out.foot = foot;
        }
        self.land(&h);
    }

    fn land(&mut self, h: &Hit) {
        self.out.ground = Some(self.ground_of(h));
    }

    /// What was hit, as ground.
    pub fn ground_of(&self, h: &Hit) -> CharacterGround {
        let w = self.around.world;
        let slot = w.shapes[h.shape].body;
        let body = &w.bodies[slot];
        let (v, turn) = w.velocities(body);
        let velocity = match body.kind {
            BodyKind::Dynamic => v + turn.cross((h.point - w.frames[slot as usize].center).as_vec3()),
            _ => self.around.carried(slot, h.point) * self.around.per_second(),
        };
        CharacterGround {
            body: w.body_id(slot),
            shape: w.shape_id(h.shape),
            point: h.point,
            normal: h.normal,
            velocity,
        }
    }

    /// What is below within `reach`, and whether it carries.
    pub fn down(&self, reach: f32) -> Option<(Hit, bool)> {
        let h = self.cast_down(self.out.foot, reach)?;
        let there = self.out.foot - (self.around.up * h.go).as_dvec3();
        Some((h, self.carries(there, &h)))
    }

    /// Along with what it stands on, past nothing else.
    pub fn carry(&mut self, ground: u32, way: Vec3) {
        if way == Vec3::ZERO {
            return;
        }
        let a = &self.around;
        let hit = a.cast(self.out.foot, way, |s, _| a.world.shapes[s].body != ground && !a.one_way(s));
        let part = hit.map_or(1.0, |h| h.go / way.length());
        self.out.foot += (way * part).as_dvec3();
    }
}

impl Walk<'_, '_> {
    /// Normal of the ground it stands on, where that may be walked on.
    pub fn floor_normal(&self) -> Option<Vec3> {
        let h = self.cast_down(self.out.foot, 2.0 * self.around.mover.skin)?;
        self.walkable(h.normal).then_some(h.normal)
    }
}
