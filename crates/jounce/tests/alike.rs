//! Sets of joints that are alike are solved side by side in lanes: what that must not change.

mod common;

use common::rng::Rng;
use jounce::geometry::HeightField;
use jounce::math::scalar::f64s;
use jounce::prelude::*;
use jounce::{JointDesc, JointSolver, Ragdoll, RagdollDesc};
use std::sync::Arc;

fn weightless() -> World {
    World::new(WorldDesc { gravity: Vec3::ZERO, ..WorldDesc::default() }).unwrap()
}

/// Without friction and springs, which the two solvers take in a different order.
fn plain() -> RagdollDesc {
    let mut d = RagdollDesc::human();
    for j in d.bones.iter_mut().filter_map(|b| b.joint.as_mut()) {
        (j.friction, j.rest_spring) = (0.0, None);
    }
    d
}

fn spin(w: &mut World, doll: &Ragdoll, seed: u64, most: f32) {
    let mut rng = Rng::new(seed);
    for &b in &doll.bodies {
        w.set_velocity(b, rng.vec3(0.1 * most)).unwrap();
        w.set_angular_velocity(b, rng.vec3(most)).unwrap();
    }
}

/// One joint asks for the direct solver: the others follow.
fn alone(w: &mut World, doll: &Ragdoll) {
    let j = doll.joints[1].unwrap();
    let d = JointDesc { solver: JointSolver::Direct, ..w.joint(j).unwrap().desc().clone() };
    w.remove_joint(j).unwrap();
    w.add_joint(d).unwrap();
}

fn hills() -> ShapeDesc {
    let wave =
        |k: usize| 0.3 * jounce::math::scalar::f32s::sin(0.9 * (k % 33) as f32 + 0.6 * (k / 33) as f32);
    let field = HeightField::new(33, 33, [1.0, 1.0], (0..33 * 33).map(wave).collect()).unwrap();
    ShapeDesc::new(Shape::HeightField(Arc::new(field)))
}

/// One doll falls on hills; far away, out of reach, fall none, three or forty others: their lanes do not touch its bits.
#[test]
fn who_stands_in_the_other_lanes_does_not_matter() {
    let fall = |others: usize| {
        let mut w = World::new(WorldDesc::default()).unwrap();
        w.add_body(BodyDesc::fixed().shape(hills())).unwrap();
        w.add_body(BodyDesc::fixed().at([200.0, 0.0, 0.0]).shape(hills())).unwrap();
        let mut rng = Rng::new(5);
        // Some before it and some after, so that it is not in the first lane.
        let more = |w: &mut World, n: usize, rng: &mut Rng| {
            for _ in 0..n {
                let at = DVec3::new(200.0, 3.0, 0.0) + rng.vec3(8.0).as_dvec3();
                w.add_ragdoll(&RagdollDesc::human().at(at).rotated(rng.quat()).group(-2)).unwrap();
            }
        };
        more(&mut w, others / 2, &mut rng);
        let q = Quat::from_axis_angle(Vec3::new(0.36, 0.48, 0.8), 1.0);
        let doll = w.add_ragdoll(&RagdollDesc::human().at([0.0, 2.5, 0.0]).rotated(q).group(-1)).unwrap();
        more(&mut w, others - others / 2, &mut rng);
        let mut seen = Vec::new();
        for _ in 0..150 {
            w.step().unwrap();
            for &b in &doll.bodies {
                let b = w.body(b).unwrap();
                let (p, q, v) = (b.position(), b.rotation(), b.velocity());
                seen.extend([p.x, p.y, p.z].map(f64::to_bits));
                seen.extend([q.x, q.y, q.z, q.w, v.x, v.y, v.z].map(|x| u64::from(x.to_bits())));
            }
        }
        seen
    };
    let one = fall(0);
    for others in [3, 40] {
        assert!(fall(others) == one, "{others} others");
    }
}

/// In free flight, ends and all, a doll moves as the direct solver in f64 has it.
#[test]
fn it_is_what_the_direct_solver_does() {
    let mut worst = 0.0;
    for seed in 0..12 {
        let mut worlds = [weightless(), weightless()];
        let dolls = [0, 1].map(|i| {
            let doll = worlds[i].add_ragdoll(&plain().group(-1)).unwrap();
            if i == 1 {
                alone(&mut worlds[i], &doll);
            }
            spin(&mut worlds[i], &doll, seed, 4.0);
            doll
        });
        for _ in 0..12 {
            worlds.iter_mut().for_each(|w| w.step().unwrap());
        }
        for (&a, &b) in dolls[0].bodies.iter().zip(&dolls[1].bodies) {
            let (a, b) = (worlds[0].body(a).unwrap(), worlds[1].body(b).unwrap());
            worst = f64s::max(worst, (a.position() - b.position()).length());
        }
        let [a, b] = [0, 1].map(|i| worlds[i].hash());
        assert_ne!(a, b, "seed {seed}: both were solved alike");
    }
    println!("apart by {worst:.1e} m after 0.2 s");
    assert!(worst < 2e-3, "{worst} m");
}

/// Joints of all kinds that lanes know, in free flight: momenta stay, points hold, and energy is not made.
#[test]
fn momenta_stay_and_energy_is_not_made() {
    let (mut drift, mut turn, mut made, mut gap) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f32);
    for seed in 0..20 {
        let mut w = weightless();
        let mut d = plain();
        if seed % 2 == 1 {
            d = RagdollDesc::human();
        }
        // Contacts of bones with one another have levers of their own.
        d.bones.iter_mut().flat_map(|b| &mut b.shapes).for_each(|s| s.filter.mask = 0);
        let doll = w.add_ragdoll(&d.group(-1)).unwrap();
        if seed % 3 == 2 {
            // A rucksack.
            let bag = BodyDesc::dynamic()
                .at(w.body(doll.bodies[3]).unwrap().position() + DVec3::new(0.0, 0.0, -0.3))
                .shape(
                    ShapeDesc::cuboid([0.15, 0.2, 0.1])
                        .density(400.0)
                        .filter(Filter { mask: 0, ..Filter::default() }),
                );
            let bag = w.add_body(bag).unwrap();
            let at = w.body(bag).unwrap().position();
            w.add_joint(JointDesc::fixed(doll.bodies[3], bag, at)).unwrap();
        }
        // At 40 rad/s the motion of a substep passes ends, and places are put right: that must keep angular momentum too.
        let fast = seed >= 10;
        spin(&mut w, &doll, seed, if fast { 40.0 } else { 8.0 });
        // The first step makes the velocities fit the joints.
        w.step().unwrap();
        let (start, first) = (w.momentum(), w.energy().total());
        let mut least = first;
        for _ in 0..240 {
            w.step().unwrap();
            let e = w.energy().total();
            if !fast {
                made = f64s::max(made, (e - least) / first);
            }
            least = f64s::min(least, e);
            for &j in doll.joints.iter().flatten() {
                gap = jounce::math::scalar::f32s::max(gap, w.joint(j).unwrap().gap());
            }
        }
        let end = w.momentum();
        drift = f64s::max(drift, (end.linear - start.linear).length() / start.linear.length());
        turn = f64s::max(turn, (end.angular - start.angular).length() / start.angular.length());
    }
    println!("Δp {drift:.1e}, ΔL {turn:.1e} of their sizes, energy made {made:.1e}, gap {gap:.1e} m");
    assert!(drift < 1e-5 && turn < 2e-5 && gap < 2e-3, "{drift}, {turn}, {gap} m");
    // Springs of the human hold a little, and give it back.
    assert!(made < 0.02, "{made} of the energy was made");
}
