//! A snowboard on its edges.
//!
//! Symbols: R_s side-cut radius, θ edge angle (of the base against the snow), a half the edge's length, N load of a station, v velocity of a
//! station over the snow, t the edge's tangent there, b across it in the snow.
//!
//! An edge set at θ touches along all its length when the board has bent to the arc R = R_s cos θ (Howe): a circle of R_s seen from
//! the snow at θ is an ellipse of that radius at its waist. So the tangents at nose and tail are turned against each other by 2a/R, and
//! the edge, which cuts along itself and not across, makes the board run on that circle. Four stations, the ends of both edges, each hold
//!
//! * up: a damped spring, N;
//! * along t: friction, |F| ≤ μ N;
//! * across: |F| ≤ N (μ + (μ_edge − μ) min(1, sin |θ|/sin θ_e)), what the snow resists to the edge; beyond it the board skids.
//!
//! Friction is a velocity constraint with a bound, all stations in turn.
//!
//! Sources: Howe, The New Skiing Mechanics, 2001; Lind & Sanders, The Physics of Skiing, 2nd ed. 2004, 3 and 4.

use super::desc::BoardDesc;
use super::solve::{KAPPA_MIN, Now, Run, hold_roll};
use super::state::{Seen, Vehicle};
use jounce_math::{Vec3, scalar::f32s};

/// Rounds over the stations.
const ROUNDS: usize = 12;

/// Forward and left of the stations, in halves of length and width.
pub(crate) const STATIONS: [(f32, f32); 4] = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];

#[derive(Clone, Copy, Debug, Default)]
struct Work {
    arm: Vec3,
    now: Now,
    load: f32,
    t: Vec3,
    b: Vec3,
    /// Bounds along and across, N s, and impulses so far.
    most: [f32; 2],
    impulse: [f32; 2],
    /// 1/effective mass.
    k: [f32; 2],
}

pub(crate) fn substep(v: &mut Vehicle, d: &BoardDesc, run: &mut Run, h: f32) {
    let mut work = [Work::default(); 4];
    let touching = stand(v, d, run, h, &mut work);
    set_edges(d, run, &mut work);
    for _ in 0..ROUNDS {
        for w in work.iter_mut().filter(|w| w.load > 0.0) {
            for (i, e) in [w.t, w.b].into_iter().enumerate() {
                let slip = run.over(w.arm, &w.now).dot(e);
                let old = w.impulse[i];
                w.impulse[i] = f32s::clamp(old - slip / w.k[i], -w.most[i], w.most[i]);
                let push = e * (w.impulse[i] - old);
                run.chassis.push(w.arm, push);
                run.push_ground(w.arm, &w.now, push);
            }
        }
    }
    ride(v, d, run, h, &work, touching);
    for (s, w) in v.stations.iter_mut().zip(&work) {
        let slip = if w.load > 0.0 { run.over(w.arm, &w.now) } else { Vec3::ZERO };
        let along = f32s::max(slip.dot(w.t).abs(), 1e-3);
        s.seen = Seen {
            load: w.load / h,
            force: w.impulse.map(|j| j / h),
            slip: [0.0, f32s::atan2(slip.dot(w.b), along)],
            friction: if w.load > 0.0 { w.most[1] / w.load } else { 0.0 },
            normal: if w.load > 0.0 { w.now.normal } else { Vec3::ZERO },
            suspension: w.load / h,
            point: if w.load > 0.0 { run.place(w.arm) } else { s.seen.point },
            drive: 0.0,
        };
    }
}

/// Loads, and jumps.
fn stand(v: &mut Vehicle, d: &BoardDesc, run: &mut Run, h: f32, work: &mut [Work; 4]) -> usize {
    let (up, _) = run.axes();
    let q = run.chassis.m.dq;
    let mut depth = [0.0; 4];
    let mut count = 0;
    for i in 0..4 {
        let Some(plane) = run.stations[i].plane else { continue };
        let now = run.now(&plane);
        let arm = q.rotate(run.stations[i].hub);
        depth[i] = (now.point - arm).dot(now.normal);
        if depth[i] > 0.0 && now.normal.dot(up) > KAPPA_MIN {
            (work[i].arm, work[i].now) = (arm, now);
            count += 1;
        } else {
            depth[i] = 0.0;
        }
    }
    let asked = v.input.jump >= 0.5;
    let jump = if asked && !v.jumped && count > 0 { run.mass * d.jump_speed / count as f32 } else { 0.0 };
    v.jumped = asked && (v.jumped || jump > 0.0);
    let (k, c) = (0.25 * d.stiffness, 0.25 * d.damping);
    for (w, depth) in work.iter_mut().zip(depth).filter(|(_, d)| *d > 0.0) {
        let n = w.now.normal;
        let closing = -run.over(w.arm, &w.now).dot(n);
        let m = count as f32 * (run.chassis.response(w.arm, n, n) + run.ground_response(w.arm, &w.now, n, n));
        let q = h * c + h * h * k;
        let j = f32s::max((h * k * depth + q * closing) / (1.0 + q * m), 0.0);
        w.load = j;
        w.now.normal = n;
        let push = n * (j + jump);
        (w.most[0], w.most[1]) = (j, j);
        // Held until all have been asked: they are alike.
        w.t = push;
    }
    for w in work.iter().filter(|w| w.load > 0.0) {
        run.chassis.push(w.arm, w.t);
        run.push_ground(w.arm, &w.now, w.t);
    }
    count
}

/// Angle of the base against the snow: positive on the right edge.
fn edge_angle(up: Vec3, forward: Vec3, n: Vec3) -> f32 {
    f32s::atan2(n.dot(up.cross(forward)), n.dot(up))
}

fn set_edges(d: &BoardDesc, run: &Run, work: &mut [Work; 4]) {
    let (up, forward) = run.axes();
    for (w, place) in work.iter_mut().zip(STATIONS) {
        if w.load <= 0.0 {
            continue;
        }
        let n = w.now.normal;
        let along = (forward - n * forward.dot(n)).normalize_or(forward);
        let theta = edge_angle(up, forward, n);
        let (sin, cos) = (f32s::sin(theta), f32s::cos(theta));
        let set = f32s::min(sin.abs() / f32s::sin(d.edge_angle), 1.0);
        // Right edge: the nose's tangent turns right, the tail's left.
        let bend = 0.5 * d.length / (d.sidecut * f32s::max(cos, 0.05)) * set;
        let turn = if sin > 0.0 { -place.0 * bend } else { place.0 * bend };
        let across = n.cross(along);
        w.t = along * f32s::cos(turn) + across * f32s::sin(turn);
        w.b = n.cross(w.t);
        let grip = d.friction + (f32s::max(d.edge_friction, d.friction) - d.friction) * set;
        w.most = [d.friction * w.load, grip * w.load];
        for (k, e) in w.k.iter_mut().zip([w.t, w.b]) {
            *k = f32s::max(
                run.chassis.response(w.arm, e, e) + run.ground_response(w.arm, &w.now, e, e),
                1e-20,
            );
        }
    }
}

/// The rider's balance: the edge angle asked for on snow, upright in the air.
fn ride(v: &Vehicle, d: &BoardDesc, run: &mut Run, h: f32, work: &[Work; 4], touching: usize) {
    let (up, forward) = run.axes();
    let (mut n, mut height) = (Vec3::ZERO, 0.0);
    for w in work.iter().filter(|w| w.load > 0.0) {
        (n, height) = (n + w.now.normal, height - w.arm.dot(up));
    }
    let wanted = v.input.lean * d.lean_max;
    if touching == 0 || n == Vec3::ZERO {
        let g = run.gravity.length();
        if g > 0.0 {
            let error = edge_angle(up, forward, run.gravity * (-1.0 / g));
            hold_roll(run, error - wanted, d.hertz, d.damping_ratio, 0.0, h);
        }
        return;
    }
    let theta = edge_angle(up, forward, n.normalize_or(up));
    hold_roll(run, theta - wanted, d.hertz, d.damping_ratio, height / touching as f32, h);
}
