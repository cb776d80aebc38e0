//! Who hangs together: union-find over numbers from 0, each with the number of its parent.

/// The root of `i`'s group; paths are halved on the way.
pub(crate) fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        parent[i as usize] = parent[parent[i as usize] as usize];
        i = parent[i as usize];
    }
    i
}

/// Makes two groups one; tells whether they were two. The smaller root stays: the result does not depend on the order of the calls.
pub(crate) fn unite(parent: &mut [u32], a: u32, b: u32) -> bool {
    let (a, b) = (root(parent, a), root(parent, b));
    let (lo, hi) = if a < b { (a, b) } else { (b, a) };
    parent[hi as usize] = lo;
    a != b
}
