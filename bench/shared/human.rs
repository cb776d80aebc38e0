//! The ragdoll of `rain`: 14 bones and 13 joints, the main axis of a joint along z.
//!
//! Source: Box3D's *rain* benchmark (erincatto/box3d, MIT).

use super::parts::{BodyOptions, Frame, Kind, Limb, Meets, Shape, ShapeOptions, V};
use crate::world::{Body, World};

/// How a bone hangs on its parent; degrees.
#[derive(Clone, Copy)]
pub enum Hold {
    Root,
    /// Cone, twist from and to.
    Ball(f32, f32, f32),
    /// From and to.
    Hinge(f32, f32),
}

/// Spring of every joint to its rest, at which its frames coincide: hertz and damping ratio.
pub const REST_SPRING: (f32, f32) = (1.0, 0.7);
/// Friction of a joint, N m; the neck and the head have a part of it.
const FRICTION: f32 = 5.0;

struct Bone {
    name: &'static str,
    parent: Option<usize>,
    at: Frame,
    capsule: (V, V, f32),
    hold: Hold,
    on_parent: Frame,
    on_bone: Frame,
}

#[rustfmt::skip]
const BONES: [Bone; 14] = [
    Bone {
        name: "pelvis",
        parent: None,
        at: ([0.0, 0.932087, -0.051708], [0.739169, 0.0, 0.0, 0.67352]),
        capsule: ([0.07, 0.0, -0.08], [-0.07, 0.0, -0.08], 0.13),
        hold: Hold::Root,
        on_parent: ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]),
        on_bone: ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]),
    },
    Bone {
        name: "spine_01",
        parent: Some(0),
        at: ([0.0, 1.113505, -0.03481], [0.739973, 0.0, 0.0, 0.672637]),
        capsule: ([0.06, 0.0, -0.052264], [-0.06, 0.0, -0.052264], 0.12),
        hold: Hold::Ball(25.0, -15.0, 15.0),
        on_parent: ([0.0, 0.0, -0.182204], [-0.999999, 0.0, 0.0, 0.001194]),
        on_bone: ([0.0, 0.0, -0.007736], [-1.0, 0.0, 0.0, 0.0]),
    },
    Bone {
        name: "spine_02",
        parent: Some(1),
        at: ([0.0, 1.194336, -0.027087], [0.703611, 0.0, 0.0, 0.710586]),
        capsule: ([0.08, -0.015133, -0.091801], [-0.08, -0.015133, -0.091801], 0.1),
        hold: Hold::Ball(25.0, -15.0, 15.0),
        on_parent: ([0.0, 0.0, -0.088935], [-0.998619, 0.0, 0.0, -0.05254]),
        on_bone: ([0.0, 0.0, -0.008199], [-1.0, 0.0, 0.0, 0.0]),
    },
    Bone {
        name: "spine_03",
        parent: Some(2),
        at: ([0.0, 1.31043, -0.028232], [0.669856, 1e-06, -1e-06, 0.742491]),
        capsule: ([0.11, -0.039753, -0.13], [-0.11, -0.039753, -0.13], 0.145),
        hold: Hold::Ball(15.0, -10.0, 10.0),
        on_parent: ([0.0, 0.0, -0.124298], [-0.998921, 1e-06, -1e-06, -0.046434]),
        on_bone: ([0.0, 0.0, 0.0], [-1.0, 0.0, -1e-06, 0.0]),
    },
    Bone {
        name: "neck",
        parent: Some(3),
        at: ([0.0, 1.575582, -0.055837], [0.879922, 0.0, 0.0, 0.475118]),
        capsule: ([-1e-06, 0.0, -0.02], [0.0, -0.005, -0.08], 0.07),
        hold: Hold::Ball(45.0, -15.0, 15.0),
        on_parent: ([1e-06, -0.000259, -0.266585], [-0.942192, -1e-06, 0.0, 0.335074]),
        on_bone: ([0.0, 0.0, 0.0], [-1.0, 0.0, -1e-06, 0.0]),
    },
    Bone {
        name: "head",
        parent: Some(4),
        at: ([0.0, 1.653348, -0.003241], [0.750288, 0.0, 0.0, 0.661111]),
        capsule: ([-1e-06, 0.016892, -0.05869], [0.0, -0.003629, -0.115072], 0.0975),
        hold: Hold::Ball(15.0, -15.0, 15.0),
        on_parent: ([0.0, 0.001321, -0.093873], [-0.974301, 0.0, 0.0, -0.225251]),
        on_bone: ([0.0, 0.001268, -0.005104], [-1.0, 0.0, 0.0, 0.0]),
    },
    Bone {
        name: "thigh_l",
        parent: Some(0),
        at: ([0.090416, 0.986104, -0.03509], [-0.703287, -0.070715, 0.053866, 0.705327]),
        capsule: ([0.023719, 0.006008, -0.039068], [-0.064492, -0.004664, -0.424718], 0.09),
        hold: Hold::Ball(10.0, -60.0, 40.0),
        on_parent: ([0.05, 0.011537, -0.055325], [-0.714896, -0.022305, -0.698361, -0.02679]),
        on_bone: ([0.0, 0.0, 0.0], [-0.002064, 0.758987, 0.017046, 0.65088]),
    },
    Bone {
        name: "calf_l",
        parent: Some(6),
        at: ([0.101198, 0.527027, -0.037374], [-0.653328, -0.06686, 0.058582, 0.751838]),
        capsule: ([0.001778, 0.0, 0.009841], [-0.078577, 0.014707, -0.41816], 0.075),
        hold: Hold::Hinge(-5.0, 45.0),
        on_parent: ([-0.069989, 0.000253, -0.453844], [-0.000677, 0.760087, 0.105674, 0.641171]),
        on_bone: ([0.0, 0.0, 0.0], [-0.044589, 0.76554, 0.053368, 0.639619]),
    },
    Bone {
        name: "thigh_r",
        parent: Some(0),
        at: ([-0.090416, 0.986104, -0.03509], [-0.703287, 0.070715, -0.053865, 0.705326]),
        capsule: ([-0.023719, 0.006008, -0.039068], [0.064492, -0.004664, -0.424718], 0.09),
        hold: Hold::Ball(10.0, -30.0, 60.0),
        on_parent: ([-0.05, 0.011537, -0.055326], [-0.039089, -0.714094, 0.043177, 0.697623]),
        on_bone: ([0.0, 0.0, 0.0], [0.758805, -0.019886, -0.651012, -0.001759]),
    },
    Bone {
        name: "calf_r",
        parent: Some(8),
        at: ([-0.101198, 0.527027, -0.037373], [-0.653327, 0.06686, -0.058582, 0.751839]),
        capsule: ([-0.00182, 0.0, 0.010071], [0.077883, 0.014825, -0.418047], 0.075),
        hold: Hold::Hinge(-45.0, 5.0),
        on_parent: ([0.069988, 0.000253, -0.453844], [0.760086, -0.000675, -0.641171, -0.105676]),
        on_bone: ([0.0, 0.0, 0.0], [0.76554, -0.044589, -0.639619, -0.053368]),
    },
    Bone {
        name: "upper_arm_l",
        parent: Some(3),
        at: ([0.20378, 1.484275, -0.115897], [0.143082, 0.69598, -0.69013, 0.13733]),
        capsule: ([0.0, 0.0, 0.0], [-0.091118, 0.037775, 0.229719], 0.075),
        hold: Hold::Ball(60.0, -5.0, 5.0),
        on_parent: ([0.20378, -0.069369, -0.181921], [-0.278486, 0.4456, -0.097014, 0.845266]),
        on_bone: ([0.0, 0.0, 0.0], [-0.201396, -0.001586, 0.90185, 0.382234]),
    },
    Bone {
        name: "lower_arm_l",
        parent: Some(10),
        at: ([0.305614, 1.242908, -0.117599], [0.165048, 0.563437, -0.802002, 0.109959]),
        capsule: ([0.0, 0.0, 0.0], [-0.142406, 0.039392, 0.261092], 0.05),
        hold: Hold::Hinge(-5.0, 60.0),
        on_parent: ([-0.095482, 0.039584, 0.240723], [0.512487, -0.180629, 0.839474, 0.003742]),
        on_bone: ([0.0, 0.0, 0.0], [0.503803, -0.029831, 0.858168, 0.094017]),
    },
    Bone {
        name: "upper_arm_r",
        parent: Some(3),
        at: ([-0.20378, 1.484276, -0.115899], [0.143083, -0.695978, 0.690132, 0.137329]),
        capsule: ([0.0, 0.0, 0.0], [0.091118, 0.037775, 0.229718], 0.075),
        hold: Hold::Ball(60.0, -5.0, 5.0),
        on_parent: ([-0.203779, -0.069371, -0.181922], [-0.253621, -0.414842, 0.106962, 0.867261]),
        on_bone: ([0.0, 0.0, 0.0], [-0.201397, 0.001587, -0.90185, 0.382233]),
    },
    Bone {
        name: "lower_arm_r",
        parent: Some(12),
        at: ([-0.305614, 1.242907, -0.117599], [0.165048, -0.563437, 0.802002, 0.109959]),
        capsule: ([0.0, 0.0, 0.0], [0.142406, 0.039392, 0.261092], 0.05),
        hold: Hold::Hinge(-60.0, 5.0),
        on_parent: ([0.095484, 0.039585, 0.240723], [-0.180627, 0.512487, -0.003744, -0.839474]),
        on_bone: ([0.0, 0.0, 0.0], [-0.029831, 0.503803, -0.094017, -0.858169]),
    },
];

/// A person who stands on `feet`. Spine and thighs of one group never touch one another; nor do bones that a joint
/// connects, nor the two thighs.
pub fn spawn(world: &mut World, feet: V, group: u32) -> [Body; 14] {
    let bodies: [Body; 14] = std::array::from_fn(|i| {
        let bone = &BONES[i];
        let (p, turn) = bone.at;
        let mut options = BodyOptions::new(Kind::Dynamic, p[0] + feet[0], p[1] + feet[1], p[2] + feet[2]);
        options.frame.1 = turn;
        let body = world.body(&options);
        let (a, b, radius) = bone.capsule;
        let grouped = matches!(bone.name, "spine_01" | "thigh_l" | "thigh_r");
        let meets = if grouped { Meets::NotGroup(group) } else { Meets::All };
        let options = ShapeOptions { rolling: 0.2, meets, ..Default::default() };
        world.shape(body, &Shape::Capsule { a, b, radius }, options);
        body
    });
    for (bone, &body) in BONES.iter().zip(&bodies) {
        let Some(parent) = bone.parent else { continue };
        let part = match bone.name {
            "neck" => 0.8,
            "head" => 0.4,
            _ => 1.0,
        };
        world.limb(&Limb {
            a: bodies[parent],
            b: body,
            frame_a: bone.on_parent,
            frame_b: bone.on_bone,
            hold: bone.hold,
            friction: FRICTION * part,
        });
    }
    let at = |name: &str| BONES.iter().position(|b| b.name == name).map_or(bodies[0], |i| bodies[i]);
    world.pass_through(at("thigh_l"), at("thigh_r"));
    bodies
}
