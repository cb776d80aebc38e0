//! The tree against a plain list of boxes.

use super::Bvh;
use crate::Aabb;
use jounce_math::Vec3;

struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as u32
    }
    fn unit(&mut self) -> f32 {
        self.next() as f32 / (1u64 << 31) as f32
    }
    fn vec(&mut self, scale: f32) -> Vec3 {
        let mut c = || (self.unit() * 2.0 - 1.0) * scale;
        Vec3::new(c(), c(), c())
    }
    fn aabb(&mut self) -> Aabb {
        // Now and then a flat box, a point, or an exact duplicate of another place.
        let center = if self.next().is_multiple_of(8) { Vec3::splat(3.0) } else { self.vec(10.0) };
        let half = match self.next() % 4 {
            0 => Vec3::ZERO,
            1 => Vec3::new(self.unit(), 0.0, self.unit()),
            _ => self.vec(1.0).abs(),
        };
        Aabb::from_center(center, half)
    }
}

/// Tree and list of (leaf, box, data).
fn check(tree: &Bvh, list: &[(u32, Aabb, u32)], r: &mut Random) {
    tree.validate().unwrap();
    assert_eq!(tree.len(), list.len());
    assert_eq!(tree.is_empty(), list.is_empty());
    for _ in 0..8 {
        let q = r.aabb().expanded(r.unit() * 3.0);
        let (mut got, mut want) = (Vec::new(), Vec::new());
        tree.query(&q, |d| {
            got.push(d);
            true
        });
        want.extend(list.iter().filter(|l| l.1.overlaps(&q)).map(|l| l.2));
        got.sort_unstable();
        want.sort_unstable();
        assert_eq!(got, want);
        let mut got = 0;
        tree.query_boxes(&q, |d, b| {
            assert!(list.iter().any(|l| l.2 == d && l.1 == *b), "{d} has another box than {b:?}");
            got += 1;
            true
        });
        assert_eq!(got, want.len());

        let (o, d, half) = (r.vec(15.0), r.vec(1.0), Vec3::splat(r.unit()));
        let inv = Vec3::new(1.0 / d.x, 1.0 / d.y, 1.0 / d.z);
        let grown = |b: &Aabb| Aabb::new(b.min - half, b.max + half);
        let mut got = Vec::new();
        tree.ray(o, d, half, 20.0, |data, t| {
            got.push(data);
            t
        });
        let mut want: Vec<u32> =
            list.iter().filter(|l| grown(&l.1).ray_entry(o, inv, 20.0).is_some()).map(|l| l.2).collect();
        got.sort_unstable();
        want.sort_unstable();
        assert_eq!(got, want);

        let p = r.vec(12.0);
        let d2 = |b: &Aabb| (p.clamp(b.min, b.max) - p).length_squared();
        let mut best = f32::INFINITY;
        tree.nearest(p, f32::INFINITY, |data, bound| {
            let b = list.iter().find(|l| l.2 == data).unwrap().1;
            best = if d2(&b) < bound { d2(&b) } else { bound };
            best
        });
        let want = list.iter().map(|l| d2(&l.1)).fold(f32::INFINITY, |m, d| if d < m { d } else { m });
        assert_eq!(best, want);
    }
}

#[test]
fn same_answers_as_a_list_through_inserts_moves_and_removals() {
    let mut r = Random(1);
    for round in 0..20 {
        let mut list: Vec<(u32, Aabb, u32)> = (0..round * 7).map(|i| (i, r.aabb(), i * 3 + 1)).collect();
        let mut tree = Bvh::build(&list.iter().map(|l| (l.1, l.2)).collect::<Vec<_>>());
        let mut data = 1_000_000;
        for step in 0..150 {
            match r.next() % 6 {
                0 | 1 => {
                    let b = r.aabb();
                    data += 1;
                    list.push((tree.insert(b, data), b, data));
                }
                2 if !list.is_empty() => {
                    let l = list.swap_remove(r.next() as usize % list.len());
                    tree.remove(l.0);
                    tree.remove(l.0);
                    assert_eq!(tree.aabb(l.0), Aabb::EMPTY);
                }
                3 | 4 if !list.is_empty() => {
                    let k = r.next() as usize % list.len();
                    list[k].1 = r.aabb();
                    if step % 2 == 0 {
                        tree.update(list[k].0, list[k].1);
                    } else {
                        tree.enlarge(list[k].0, list[k].1);
                    }
                    assert_eq!(tree.aabb(list[k].0), list[k].1);
                    assert_eq!(tree.data(list[k].0), Some(list[k].2));
                }
                5 if step % 3 == 0 => {
                    // None, some, or all of them.
                    let every = 1 + r.next() as usize % 60;
                    let moved: Vec<usize> = (0..list.len()).filter(|k| k % every == every - 1).collect();
                    moved.iter().for_each(|&k| list[k].1 = r.aabb());
                    tree.enlarge_all(moved.len(), |enlarge| {
                        moved.iter().for_each(|&k| enlarge(list[k].0, list[k].1));
                    });
                }
                5 if step % 5 == 0 => tree.rebuild(),
                5 if step % 5 < 3 => tree.tidy(),
                5 => tree.refit(|_, b| b),
                _ => {}
            }
            if step % 10 == 0 {
                check(&tree, &list, &mut r);
            }
        }
        for l in list.drain(..) {
            tree.remove(l.0);
        }
        check(&tree, &list, &mut r);
    }
}

#[test]
fn insertion_comes_near_the_built_tree() {
    let mut r = Random(2);
    let items: Vec<(Aabb, u32)> =
        (0..4000).map(|i| (Aabb::from_center(r.vec(100.0), Vec3::splat(1.0)), i)).collect();
    let built = Bvh::build(&items);
    let mut grown = Bvh::new();
    for &(b, d) in &items {
        grown.insert(b, d);
    }
    assert!(grown.cost() < 1.5 * built.cost(), "{} against {}", grown.cost(), built.cost());
    // Sorted input is the classic way to make a list of a tree.
    let mut line = Bvh::new();
    for i in 0..4000u32 {
        line.insert(Aabb::from_center(Vec3::X * (2.0 * i as f32), Vec3::splat(1.0)), i);
    }
    line.validate().unwrap();
    let mut depth_cost = line.clone();
    depth_cost.rebuild();
    assert!(line.cost() < 2.0 * depth_cost.cost(), "{} against {}", line.cost(), depth_cost.cost());
}

/// Leaves that drift apart, a few at a time or all, leave a tree that is as good as one built anew; and the others' subtrees stay.
#[test]
fn tidied_trees_stay_good() {
    let mut r = Random(3);
    for moving in [40, 1000, 4000] {
        let mut at: Vec<Vec3> = (0..4000).map(|_| r.vec(100.0)).collect();
        let step: Vec<Vec3> = (0..4000).map(|_| r.vec(2.0)).collect();
        let boxed = |p: Vec3| Aabb::from_center(p, Vec3::splat(1.0));
        let mut tree = Bvh::build(&at.iter().zip(0..).map(|(&p, i)| (boxed(p), i)).collect::<Vec<_>>());
        for _ in 0..200 {
            for i in 0..moving {
                at[i] += step[i];
                tree.enlarge(i as u32, boxed(at[i]));
            }
            tree.tidy();
        }
        tree.validate().unwrap();
        let mut anew = tree.clone();
        anew.rebuild();
        assert!(tree.cost() < 1.6 * anew.cost(), "{moving}: {} against {}", tree.cost(), anew.cost());
        let mut untidy = Bvh::build(&at.iter().zip(0..).map(|(&p, i)| (boxed(p), i)).collect::<Vec<_>>());
        untidy.enlarge(7, boxed(Vec3::splat(500.0)));
        let before = untidy.nodes.len();
        untidy.build_grown();
        untidy.validate().unwrap();
        assert_eq!(untidy.nodes.len(), before, "nodes are used again");
    }
}

/// Centres at 2⁻ⁱ make the heuristic peel off one leaf at a time; equal boxes give it nothing to go by.
#[test]
fn hostile_input_stays_shallow() {
    let mut items: Vec<(Aabb, u32)> = (0..120)
        .map(|i| {
            (Aabb::from_center(Vec3::X * jounce_math::scalar::f32s::pow(2.0, -(i as f32)), Vec3::ZERO), i)
        })
        .collect();
    items.extend((120..5000).map(|i| (Aabb::from_center(Vec3::Y, Vec3::ONE), i)));
    let tree = Bvh::build(&items);
    tree.validate().unwrap();
    let (mut todo, mut deepest) = (vec![(tree.root, 0)], 0);
    while let Some((n, depth)) = todo.pop() {
        deepest = deepest.max(depth);
        let children = tree.nodes[n as usize].children.into_iter();
        todo.extend(children.filter(|c| c & super::LEAF == 0).map(|c| (c, depth + 1)));
    }
    assert!(deepest < 60, "{deepest}");
    let mut count = 0;
    tree.query(&Aabb::from_center(Vec3::ZERO, Vec3::splat(10.0)), |_| {
        count += 1;
        true
    });
    assert_eq!(count, 5000);
}

#[test]
fn a_node_is_one_cache_line() {
    assert_eq!(core::mem::size_of::<super::Node>(), 64);
}
