//! Barnes and Hut's octree: distant groups of bodies pull as one.
//!
//! A cube around all bodies is split into eight until a cube holds few. A cube of side s, whose centre of mass lies at a
//! distance d, pulls as one body where d > s/θ + δ, and is opened otherwise. θ: opening angle; δ: distance between the
//! centre of mass and the middle of the cube, without which a body could stand inside a cube that is not opened.
//!
//! The order of nodes and sums follows from the order of the bodies alone.
//! Source: J. Barnes and P. Hut, Nature 324 (1986); the criterion: J. E. Barnes, in *Computational Astrophysics* (1994).

use crate::force::gravitation;
use crate::limits::OCTREE_DEPTH_MAX;
use jounce_math::DVec3;

/// Bodies in a leaf; opening one costs about as much as one more level.
const LEAF: usize = 8;

#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// Middle of the cube and half of its side.
    middle: DVec3,
    half: f64,
    /// Bodies of the cube, as a range of `order`.
    start: u32,
    end: u32,
    depth: u32,
    /// First child and number of children; none: a leaf.
    first: u32,
    children: u32,
    mass: f64,
    center: DVec3,
    /// Distance beyond which it pulls as one, squared.
    reach: f64,
}

/// The tree; its memory is kept from one build to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Octree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    sorted: Vec<u32>,
}

impl Octree {
    /// Builds it over bodies whose positions are finite.
    pub(crate) fn build(&mut self, x: &[DVec3], masses: &[f64], opening_angle: f64) {
        self.nodes.clear();
        self.order.clear();
        self.order.extend(0..x.len() as u32);
        self.sorted.resize(x.len(), 0);
        let Some(&first) = x.first() else { return };
        let (lo, hi) = x.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
        let (middle, half) = ((lo + hi) * 0.5, (hi - lo).max_component() * 0.5);
        self.nodes.push(Node { middle, half, end: x.len() as u32, ..Node::default() });
        let mut n = 0;
        // Children are pushed behind their parent, so that one pass over the growing list splits everything.
        while n < self.nodes.len() {
            self.split(n, x);
            n += 1;
        }
        for n in (0..self.nodes.len()).rev() {
            self.weigh(n, x, masses, opening_angle);
        }
    }

    fn split(&mut self, n: usize, x: &[DVec3]) {
        let node = self.nodes[n];
        let (start, end) = (node.start as usize, node.end as usize);
        if end - start <= LEAF || node.depth as usize >= OCTREE_DEPTH_MAX || node.half == 0.0 {
            return;
        }
        let octant = |i: u32| {
            let p = x[i as usize];
            usize::from(p.x >= node.middle.x)
                | usize::from(p.y >= node.middle.y) << 1
                | usize::from(p.z >= node.middle.z) << 2
        };
        // A counting sort, which keeps the order of the bodies within each octant.
        let mut counts = [0usize; 8];
        for &i in &self.order[start..end] {
            counts[octant(i)] += 1;
        }
        let mut next = [start; 8];
        for o in 1..8 {
            next[o] = next[o - 1] + counts[o - 1];
        }
        let starts = next;
        for k in start..end {
            let i = self.order[k];
            let o = octant(i);
            self.sorted[next[o]] = i;
            next[o] += 1;
        }
        self.order[start..end].copy_from_slice(&self.sorted[start..end]);
        let first = self.nodes.len() as u32;
        let half = 0.5 * node.half;
        for o in (0..8).filter(|&o| counts[o] > 0) {
            let sign = |bit: usize| if o >> bit & 1 == 1 { half } else { -half };
            self.nodes.push(Node {
                middle: node.middle + DVec3::new(sign(0), sign(1), sign(2)),
                half,
                start: starts[o] as u32,
                end: (starts[o] + counts[o]) as u32,
                depth: node.depth + 1,
                ..Node::default()
            });
        }
        (self.nodes[n].first, self.nodes[n].children) = (first, self.nodes.len() as u32 - first);
    }

    /// Mass, centre of mass and reach, children first.
    fn weigh(&mut self, n: usize, x: &[DVec3], masses: &[f64], opening_angle: f64) {
        let node = self.nodes[n];
        let (mut mass, mut moment) = (0.0, DVec3::ZERO);
        let mut add = |m: f64, p: DVec3| {
            mass += m;
            moment += (p - node.middle) * m;
        };
        if node.children == 0 {
            for &i in &self.order[node.start as usize..node.end as usize] {
                add(masses[i as usize], x[i as usize]);
            }
        } else {
            for c in node.first..node.first + node.children {
                let c = &self.nodes[c as usize];
                add(c.mass, c.center);
            }
        }
        let offset = if mass > 0.0 { moment / mass } else { DVec3::ZERO };
        let reach = 2.0 * node.half / opening_angle + offset.length();
        let node = &mut self.nodes[n];
        (node.mass, node.center, node.reach) = (mass, node.middle + offset, reach * reach);
    }

    /// Acceleration of body `i` by all the others, m/s².
    pub(crate) fn acceleration(
        &self,
        i: usize,
        x: &[DVec3],
        masses: &[f64],
        g: f64,
        softening: f64,
    ) -> DVec3 {
        let at = x[i];
        let mut sum = DVec3::ZERO;
        if self.nodes.is_empty() {
            return sum;
        }
        // Every level leaves at most seven brothers of the node that is followed.
        let mut waiting = [0u32; 7 * OCTREE_DEPTH_MAX + 8];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = &self.nodes[waiting[count] as usize];
            let d = node.center - at;
            if d.length_squared() > node.reach {
                sum += gravitation(g, 1.0, node.mass, d, softening);
            } else if node.children == 0 {
                for &j in &self.order[node.start as usize..node.end as usize] {
                    let j = j as usize;
                    if j != i {
                        sum += gravitation(g, 1.0, masses[j], x[j] - at, softening);
                    }
                }
            } else {
                for c in (node.first..node.first + node.children).rev() {
                    waiting[count] = c;
                    count += 1;
                }
            }
        }
        sum
    }
}
