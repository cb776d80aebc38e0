//! Mortar of a scene file: whom it holds and how. Where bodies touch is known when a simulation starts.

use super::{JointNames, stiffness};
use crate::bodies::{Names, Target};
use crate::error::{Checked, Under, Wrong};
use crate::limits;
use crate::spec::MortarSpec;
use jounce::GlueDesc;

/// One entry of `mortar`.
#[derive(Clone, Debug)]
pub(crate) struct Mortar {
    pub name: Option<String>,
    pub bodies: Vec<Target>,
    pub desc: GlueDesc,
}

/// All entries of `mortar`. Their joints get their names, as many as a scene may have: how many there are is not known yet.
pub(crate) fn mortar(all: &[MortarSpec], names: &Names, joints: &mut JointNames) -> Checked<Vec<Mortar>> {
    all.iter().enumerate().map(|(i, m)| one(m, names, joints).index(i).key("mortar")).collect()
}

fn one(m: &MortarSpec, names: &Names, joints: &mut JointNames) -> Checked<Mortar> {
    let mut bodies: Vec<Target> = Vec::with_capacity(m.bodies.len());
    for (i, text) in m.bodies.iter().enumerate() {
        bodies.push(names.resolve(text).index(i).key("bodies")?);
    }
    let n = bodies.iter().map(|t| t.count).sum::<u64>();
    if n < 2 {
        return Err(Wrong::new(format!("names {n} bodies"), "two at least, which touch").key("bodies"));
    }
    if m.bodies.iter().all(|b| names.unmoved(b).is_some()) {
        return Err(Wrong::new("names no dynamic body", "some that mortar can hold").key("bodies"));
    }
    let mut desc = GlueDesc::new(m.strength);
    desc.gap = m.gap.unwrap_or(desc.gap);
    desc.area_min = m.area_min.unwrap_or(desc.area_min);
    desc.softness = m.softness.as_ref().map(stiffness).transpose().key("softness")?;
    desc.check()?;
    if let Some(name) = &m.name {
        joints.add_named(name, limits::SCENE_JOINTS_MAX, "fixed")?;
    }
    Ok(Mortar { name: m.name.clone(), bodies, desc })
}
