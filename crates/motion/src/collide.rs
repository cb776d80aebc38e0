//! Particles, edges and faces against planes, and the bounce.
//!
//! A plane is a point P and a unit normal N towards the outside. For a point X, (X − P)·N is above 0 outside, 0 on it,
//! below 0 inside; whoever is inside is pushed out along N.
//!
//! The bounce: V_n = (N·V) N, V_t = V − V_n, V_b = (1 − K_f) V_t − K_r V_n. K_r is the coefficient of restitution (1:
//! perfectly elastic, 0: sticks), K_f the coefficient of friction (1: stops in its tracks, 0: none). The slide prints
//! V_n = (N·V) V, which is not even along N; the normal component has N in both places.
//! Source: the lecture.

use crate::error::{Error, Result, check, finite_vector, positive};
use jounce_math::DVec3;

/// Where a point is, seen from a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// (X − P)·N > 0.
    Outside,
    /// (X − P)·N = 0.
    On,
    /// (X − P)·N < 0.
    Inside,
}

/// A plane by a point on it and its outward normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    point: DVec3,
    normal: DVec3,
}

impl Plane {
    /// The plane through `point` in m with this normal, of any length above 0.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::collide::{Plane, Side};
    /// let floor = Plane::new(DVec3::ZERO, DVec3::Y * 2.0)?;
    /// assert_eq!(floor.side(DVec3::Y * 0.1), Side::Outside);
    /// assert_eq!(floor.side(DVec3::X), Side::On);
    /// assert_eq!(floor.side(DVec3::Y * -0.1), Side::Inside);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::BadValue`] for a point that is not finite or a normal without direction.
    pub fn new(point: DVec3, normal: DVec3) -> Result<Self> {
        finite_vector("plane", "point", point)?;
        let Some((normal, _)) = normal.try_normalize() else {
            return Err(crate::error::bad("plane", "normal", normal.to_array(), "a finite vector, not zero"));
        };
        Ok(Self { point, normal })
    }

    /// A point on it, m.
    pub fn point(&self) -> DVec3 {
        self.point
    }

    /// Its unit normal.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// (X − P)·N, m.
    #[inline]
    pub fn distance(&self, x: DVec3) -> f64 {
        (x - self.point).dot(self.normal)
    }

    /// On which side a point is.
    pub fn side(&self, x: DVec3) -> Side {
        let d = self.distance(x);
        if d > 0.0 {
            Side::Outside
        } else if d < 0.0 {
            Side::Inside
        } else {
            Side::On
        }
    }

    /// The point itself, or, where it is inside, the nearest one on the surface.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::collide::Plane;
    /// let floor = Plane::new(DVec3::ZERO, DVec3::Y)?;
    /// assert_eq!(floor.push_out(DVec3::new(3.0, -0.2, 0.0)), DVec3::X * 3.0);
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    #[inline]
    pub fn push_out(&self, x: DVec3) -> DVec3 {
        let d = self.distance(x);
        if d < 0.0 { x - self.normal * d } else { x }
    }

    /// Pushes a particle out and lets it bounce; true where it was inside. `k_r` and `k_f` as in [`respond`].
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::collide::Plane;
    /// let floor = Plane::new(DVec3::ZERO, DVec3::Y)?;
    /// let (mut x, mut v) = (DVec3::Y * -0.01, DVec3::new(1.0, -2.0, 0.0));
    /// assert!(floor.collide(&mut x, &mut v, 0.5, 0.1));
    /// assert_eq!((x, v), (DVec3::ZERO, DVec3::new(0.9, 1.0, 0.0)));
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    #[inline]
    pub fn collide(&self, x: &mut DVec3, v: &mut DVec3, k_r: f64, k_f: f64) -> bool {
        let inside = self.distance(*x) < 0.0;
        if inside {
            *x = self.push_out(*x);
            *v = respond(*v, self.normal, k_r, k_f);
        }
        inside
    }
}

/// A ball that particles stay out of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    center: DVec3,
    radius: f64,
}

impl Ball {
    /// Around `center`, with `radius` above 0, in m.
    ///
    /// # Errors
    /// [`Error::BadValue`] for a centre that is not finite or a radius that is not above 0.
    pub fn new(center: DVec3, radius: f64) -> Result<Self> {
        finite_vector("ball", "center", center)?;
        positive("ball", "radius", radius)?;
        Ok(Self { center, radius })
    }

    /// Its centre, m.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Its radius, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Pushes a particle out and lets it bounce; true where it was inside.
    ///
    /// ```
    /// use jounce_math::DVec3;
    /// use jounce_motion::collide::Ball;
    /// let ball = Ball::new(DVec3::ZERO, 1.0)?;
    /// let (mut x, mut v) = (DVec3::Y * 0.9, DVec3::Y * -2.0);
    /// assert!(ball.collide(&mut x, &mut v, 1.0, 0.0));
    /// assert_eq!((x, v), (DVec3::Y, DVec3::Y * 2.0));
    /// # Ok::<(), jounce_motion::Error>(())
    /// ```
    #[inline]
    pub fn collide(&self, x: &mut DVec3, v: &mut DVec3, k_r: f64, k_f: f64) -> bool {
        let from = *x - self.center;
        let inside = from.length_squared() < self.radius * self.radius;
        if inside {
            // At the very centre every way out is as good.
            let n = from.normalize_or(DVec3::Y);
            *x = self.center + n * self.radius;
            *v = respond(*v, n, k_r, k_f);
        }
        inside
    }
}

/// Velocity after a bounce off a surface of unit normal `n`: V_b = (1 − K_f) V_t − K_r V_n. A velocity that already
/// leaves the surface stays as it is.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::collide::respond;
/// let v = DVec3::new(3.0, -4.0, 0.0);
/// assert_eq!(respond(v, DVec3::Y, 1.0, 0.0), DVec3::new(3.0, 4.0, 0.0));
/// assert_eq!(respond(v, DVec3::Y, 0.5, 1.0), DVec3::new(0.0, 2.0, 0.0));
/// assert_eq!(respond(-v, DVec3::Y, 0.5, 1.0), -v);
/// ```
#[inline]
pub fn respond(v: DVec3, n: DVec3, k_r: f64, k_f: f64) -> DVec3 {
    let (normal, tangential) = split(v, n);
    if v.dot(n) >= 0.0 { v } else { tangential * (1.0 - k_f) - normal * k_r }
}

/// Normal and tangential component of a velocity at a surface of unit normal `n`: V_n = (N·V) N and V_t = V − V_n.
///
/// ```
/// use jounce_math::DVec3;
/// let (n, t) = jounce_motion::collide::split(DVec3::new(3.0, -4.0, 1.0), DVec3::Y);
/// assert_eq!((n, t), (DVec3::Y * -4.0, DVec3::new(3.0, 0.0, 1.0)));
/// ```
#[inline]
pub fn split(v: DVec3, n: DVec3) -> (DVec3, DVec3) {
    let normal = n * n.dot(v);
    (normal, v - normal)
}

/// How an edge lies to a plane or to a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeHit {
    /// It does not reach it.
    Misses,
    /// It passes through here.
    Crosses {
        /// Part of the way from the first end to the second, 0 to 1.
        t: f64,
        /// The point, m.
        point: DVec3,
    },
    /// Both ends lie in the plane.
    Within,
}

/// An edge from `a` to `b` against a plane. As the path of a particle in a step it gives the moment of impact.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::collide::{EdgeHit, Plane, edge_plane};
/// let floor = Plane::new(DVec3::ZERO, DVec3::Y)?;
/// let hit = edge_plane(DVec3::Y, DVec3::new(4.0, -3.0, 0.0), &floor);
/// assert_eq!(hit, EdgeHit::Crosses { t: 0.25, point: DVec3::X });
/// assert_eq!(edge_plane(DVec3::Y, DVec3::Y * 2.0, &floor), EdgeHit::Misses);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
pub fn edge_plane(a: DVec3, b: DVec3, plane: &Plane) -> EdgeHit {
    let (da, db) = (plane.distance(a), plane.distance(b));
    if da == 0.0 && db == 0.0 {
        return EdgeHit::Within;
    }
    // Not `da * db > 0`: the product of two small distances can underflow.
    if (da > 0.0 && db > 0.0) || (da < 0.0 && db < 0.0) || !(da - db).is_finite() {
        return EdgeHit::Misses;
    }
    let t = da / (da - db);
    EdgeHit::Crosses { t, point: a.lerp(b, t) }
}

/// How two planes lie to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanePair {
    /// They meet in a line.
    Meet {
        /// A point of the line, m: the one nearest to the first plane's point.
        point: DVec3,
        /// Unit vector along the line.
        direction: DVec3,
    },
    /// They never meet.
    Parallel {
        /// Distance of the second plane from the first, along the first one's normal, m; 0 where they are the same.
        distance: f64,
    },
}

/// Two planes. Normals nearer to parallel than 1e-12 rad count as parallel.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::collide::{Plane, PlanePair, plane_plane};
/// let floor = Plane::new(DVec3::ZERO, DVec3::Y)?;
/// let wall = Plane::new(DVec3::X * 2.0, -DVec3::X)?;
/// let meet = plane_plane(&floor, &wall);
/// assert_eq!(meet, PlanePair::Meet { point: DVec3::X * 2.0, direction: DVec3::Z });
/// let ceiling = Plane::new(DVec3::Y * 3.0, -DVec3::Y)?;
/// assert_eq!(plane_plane(&floor, &ceiling), PlanePair::Parallel { distance: 3.0 });
/// # Ok::<(), jounce_motion::Error>(())
/// ```
pub fn plane_plane(a: &Plane, b: &Plane) -> PlanePair {
    let cross = a.normal.cross(b.normal);
    let sine = cross.length();
    if sine < 1e-12 {
        return PlanePair::Parallel { distance: a.distance(b.point) };
    }
    let direction = cross / sine;
    // From P_a along plane a, across the line, until plane b is reached.
    let across = direction.cross(a.normal);
    let point = a.point - across * (b.distance(a.point) / b.normal.dot(across));
    PlanePair::Meet { point, direction }
}

/// An edge against a convex face, given by its corners in order around it.
///
/// # Errors
/// [`Error::BadValue`] for fewer than three corners, or corners without a plane.
pub fn edge_face(a: DVec3, b: DVec3, face: &[DVec3]) -> Result<EdgeHit> {
    let plane = face_plane(face)?;
    Ok(match edge_plane(a, b, &plane) {
        EdgeHit::Crosses { point, .. } if !covers(face, &plane, point) => EdgeHit::Misses,
        hit => hit,
    })
}

/// True where two convex faces, given by their corners in order, cut through each other: an edge of one passes through
/// the other. Faces in one plane do not cut.
///
/// ```
/// use jounce_math::DVec3;
/// use jounce_motion::collide::faces_cut;
/// let floor = [[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]].map(DVec3::from);
/// let blade = [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0]].map(DVec3::from);
/// assert!(faces_cut(&floor, &blade)?);
/// assert!(!faces_cut(&floor, &blade.map(|p| p + DVec3::X * 3.0))?);
/// # Ok::<(), jounce_motion::Error>(())
/// ```
///
/// # Errors
/// [`Error::BadValue`] for fewer than three corners, or corners without a plane.
pub fn faces_cut(a: &[DVec3], b: &[DVec3]) -> Result<bool> {
    for (edges, face) in [(a, b), (b, a)] {
        let plane = face_plane(face)?;
        face_plane(edges)?;
        for (i, &from) in edges.iter().enumerate() {
            let to = edges[(i + 1) % edges.len()];
            if let EdgeHit::Crosses { point, .. } = edge_plane(from, to, &plane)
                && covers(face, &plane, point)
            {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// The plane of a face, by Newell's sum over its edges.
fn face_plane(face: &[DVec3]) -> Result<Plane> {
    check(face.len() >= 3, "face", "corners", face.len(), "three corners or more")?;
    let first = face[0];
    let mut normal = DVec3::ZERO;
    for pair in face[1..].windows(2) {
        normal += (pair[0] - first).cross(pair[1] - first);
    }
    Plane::new(first, normal).map_err(|_| Error::Unsupported {
        what: "face",
        advice: "its corners lie on a line or are not finite; give corners that span a plane",
    })
}

/// True where a point of the face's plane lies within its edges.
fn covers(face: &[DVec3], plane: &Plane, x: DVec3) -> bool {
    (0..face.len()).all(|i| {
        let (a, b) = (face[i], face[(i + 1) % face.len()]);
        (b - a).cross(x - a).dot(plane.normal) >= 0.0
    })
}
