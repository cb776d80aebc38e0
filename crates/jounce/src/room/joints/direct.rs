//! The direct solver of joints that hang together.
//!
//! All rows that hold, of all joints of a set, at once: A λ = r, A = J M⁻¹ Jᵀ, a sparse symmetric matrix of blocks. Block (i, j) is
//! there where joints i and j share a moving body. With D_k the diagonal block of the joint that is eliminated as the k-th,
//!
//! A = L D Lᵀ: for each later neighbours i ≥ j of k: A_ij −= A_ik D_k⁻¹ A_jkᵀ,
//!
//! forward y_i −= A_ik D_k⁻¹ y_k, backward λ_k = D_k⁻¹ (y_k − Σ A_ikᵀ λ_i). Chains and trees eliminated from their leaves have no
//! fill-in: work grows with their length. Loops fill in; the order is that of least degree. f64: a kilogram chain under ten tons
//! has a condition number of 10⁹.
//!
//! Joints beyond a spanning forest close loops; their rows may say again what others say (two hinges of a door). Such a row's pivot
//! vanishes; their diagonal is raised by [`CLOSING_COMPLIANCE`] of itself, so that they yield instead. What is left of it at the last
//! joint of a long loop drowns in the rounding of J M⁻¹ Jᵀ, 1e-7 of the diagonal, where a pivot can be anything. So all joints of a
//! loop yield by [`LOOP_COMPLIANCE`]: no pivot falls below that part of its diagonal.
//!
//! Source: Baraff, Linear-time dynamics using Lagrange multipliers, 1996; George & Liu, Computer solution of large sparse positive
//! definite systems, 1981.

use crate::groups::unite;

/// Rows of a joint at most: those that hold, and ends and motors that act at the time.
pub(crate) const ROWS: usize = 12;
/// Part of their own diagonal that is added to the rows of joints that close loops, and to those of the others of a loop.
const CLOSING_COMPLIANCE: f64 = 1e-3;
const LOOP_COMPLIANCE: f64 = 1e-5;
/// The same where it is asked how they share what they bear: a bridge of twenty hinges would lose a third of its weight to 10⁻³.
const SHARED_COMPLIANCE: f64 = 1e-8;
/// A pivot below this part of its diagonal belongs to a row that others make superfluous.
const PIVOT_MIN: f64 = 1e-11;

/// A block below the diagonal, in a column.
#[derive(Clone, Copy, Debug)]
struct Below {
    /// Position of its row, and where it is.
    row: u32,
    at: u32,
}

/// Who meets whom, and in which order: depends on who is joined to whom alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// Most rows of each joint, by position.
    sizes: Vec<u8>,
    /// Joint by position, and position by joint.
    order: Vec<u32>,
    position: Vec<u32>,
    /// Start of each joint's rows in vectors, by position.
    first: Vec<u32>,
    /// Diagonal block by position.
    diagonal: Vec<u32>,
    /// Blocks below, all columns one after another.
    below: Vec<Below>,
    columns: Vec<u32>,
    /// For each pair of blocks of a column, what it changes.
    targets: Vec<u32>,
    /// Closes a loop, by position.
    closes: Vec<bool>,
    /// Is part of a loop, by position.
    looped: Vec<bool>,
    floats: usize,
    rows: usize,
}

/// A step of the elimination: a joint, its block, those below by joint and place, and what each pair of them changes.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub joint: usize,
    pub diagonal: usize,
    pub below: Vec<(usize, usize)>,
    pub targets: Vec<usize>,
}

/// Memory of the numbers; not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Numbers {
    /// Blocks; those on the diagonal become their inverses.
    a: Vec<f64>,
    /// Right side, then the result, by position.
    x: Vec<f64>,
    scratch: Vec<f64>,
    /// Rows that take part now, by position; blocks are packed to them.
    size: Vec<u8>,
}

impl Numbers {
    fn size(&self, position: u32) -> usize {
        usize::from(self.size[position as usize])
    }
}

impl Plan {
    /// `links`: for each joint, its rows and the moving bodies it acts on (`u32::MAX`: none). `None` where the blocks below the
    /// diagonal would be more than `most`.
    pub fn new(links: &[(u8, [u32; 2])], bodies: usize, most: usize) -> Option<Self> {
        let n = links.len();
        let mut at_body = vec![Vec::new(); bodies];
        let mut parent: Vec<u32> = (0..bodies as u32 + 1).collect();
        let mut closes = vec![false; n];
        for (i, (_, pair)) in links.iter().enumerate() {
            // All that does not move is one.
            let [a, b] = pair.map(|b| b.min(bodies as u32));
            closes[i] = !unite(&mut parent, a, b);
            for &b in pair {
                if let Some(list) = at_body.get_mut(b as usize) {
                    list.push(i as u32);
                }
            }
        }
        let (order, columns) = eliminate(n, &at_body, most)?;
        let looped = looped(links, &closes, bodies as u32);
        let mut position = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            position[i as usize] = k as u32;
        }
        let mut plan = Self {
            sizes: order.iter().map(|&i| links[i as usize].0).collect(),
            looped: order.iter().map(|&i| looped[i as usize]).collect(),
            closes: order.iter().map(|&i| closes[i as usize]).collect(),
            position,
            order,
            ..Self::default()
        };
        plan.lay_out(&columns);
        Some(plan)
    }

    fn lay_out(&mut self, columns: &[Vec<u32>]) {
        let size = |p: u32, sizes: &[u8]| usize::from(sizes[p as usize]);
        for k in 0..self.order.len() as u32 {
            let n = size(k, &self.sizes);
            self.first.push(self.rows as u32);
            self.rows += n;
            self.diagonal.push(self.floats as u32);
            self.floats += n * n;
        }
        for (k, column) in columns.iter().enumerate() {
            self.columns.push(self.below.len() as u32);
            let mut rows: Vec<u32> = column.iter().map(|&j| self.position[j as usize]).collect();
            rows.sort_unstable();
            for row in rows {
                self.below.push(Below { row, at: self.floats as u32 });
                self.floats += size(row, &self.sizes) * size(k as u32, &self.sizes);
            }
        }
        self.columns.push(self.below.len() as u32);
        let mut targets = Vec::new();
        for k in 0..self.order.len() {
            let column = self.column(k);
            for (n, i) in column.iter().enumerate() {
                targets.extend(column[..=n].iter().map(|j| self.block(i.row, j.row)));
            }
        }
        self.targets = targets;
    }

    fn column(&self, k: usize) -> &[Below] {
        &self.below[self.columns[k] as usize..self.columns[k + 1] as usize]
    }
    /// Where the block of two positions is; row ≥ column.
    fn block(&self, row: u32, column: u32) -> u32 {
        if row == column {
            return self.diagonal[row as usize];
        }
        let list = self.column(column as usize);
        list.binary_search_by_key(&row, |b| b.row).map_or(0, |i| list[i].at)
    }

    /// Products of blocks in the elimination.
    pub fn products(&self) -> usize {
        self.targets.len() + self.order.len()
    }
    /// Numbers in all blocks.
    pub fn floats(&self) -> usize {
        self.floats
    }
    /// Where the block of two joints is, and the joint of its rows.
    pub fn place(&self, i: usize, k: usize) -> (usize, usize) {
        let (pi, pk) = (self.position[i], self.position[k]);
        let (row, column) = if pi < pk { (pk, pi) } else { (pi, pk) };
        (self.block(row, column) as usize, if pi < pk { k } else { i })
    }
    /// The elimination, joint by joint.
    pub fn steps(&self) -> impl Iterator<Item = Step> + '_ {
        let joint = |p: u32| self.order[p as usize] as usize;
        let mut target = 0;
        (0..self.order.len()).map(move |k| {
            let below: Vec<(usize, usize)> =
                self.column(k).iter().map(|b| (joint(b.row), b.at as usize)).collect();
            let pairs = below.len() * (below.len() + 1) / 2;
            let targets = self.targets[target..target + pairs].iter().map(|&t| t as usize).collect();
            target += pairs;
            Step { joint: joint(k as u32), diagonal: self.diagonal[k] as usize, below, targets }
        })
    }
    /// Makes room for the right sides.
    pub fn reserve(&self, n: &mut Numbers) {
        n.x.clear();
        n.x.resize(self.rows, 0.0);
    }
    /// Starts a matrix of zeros; `rows` of a joint take part.
    pub fn clear(&self, n: &mut Numbers, rows: impl Fn(usize) -> usize) {
        n.a.clear();
        n.a.resize(self.floats, 0.0);
        n.size.clear();
        n.size
            .extend(self.order.iter().zip(&self.sizes).map(|(&j, &most)| (rows(j as usize) as u8).min(most)));
    }
    /// Adds `value(row of i, row of j)` to the block of joints i and j; once for the two.
    pub fn add(&self, n: &mut Numbers, i: usize, j: usize, value: impl Fn(usize, usize) -> f64) {
        let (pi, pj) = (self.position[i], self.position[j]);
        let swap = pi < pj;
        let (row, column) = if swap { (pj, pi) } else { (pi, pj) };
        let at = self.block(row, column) as usize;
        let (rows, columns) = (n.size(row), n.size(column));
        for r in 0..rows {
            for c in 0..columns {
                n.a[at + r * columns + c] += if swap { value(c, r) } else { value(r, c) };
            }
        }
    }
    /// Adds to a row's own entry.
    pub fn add_diagonal(&self, n: &mut Numbers, joint: usize, row: usize, value: f64) {
        let k = self.position[joint];
        let at = self.diagonal[k as usize] as usize + row * (n.size(k) + 1);
        n.a[at] += value;
    }
    /// Part of their own diagonal by which the rows of a joint of a loop yield.
    fn gives(&self, k: usize, even: bool) -> f64 {
        match (self.closes[k], self.looped[k]) {
            _ if even => SHARED_COMPLIANCE,
            (true, _) => CLOSING_COMPLIANCE,
            (_, true) => LOOP_COMPLIANCE,
            _ => 0.0,
        }
    }
    /// A = L D Lᵀ; `even`: all joints of loops yield alike.
    pub fn factor(&self, n: &mut Numbers, even: bool) {
        for k in (0..self.order.len()).filter(|&k| self.looped[k]) {
            let (size, d) = (n.size(k as u32), self.diagonal[k] as usize);
            let part = self.gives(k, even);
            for i in 0..size {
                n.a[d + i * size + i] *= 1.0 + part;
            }
        }
        let mut target = 0;
        for k in 0..self.order.len() {
            let size = n.size(k as u32);
            let d = self.diagonal[k] as usize;
            invert(&mut n.a[d..d + size * size], size);
            let column = self.column(k);
            for (m, i) in column.iter().enumerate() {
                let rows = n.size(i.row);
                // A_ik D⁻¹.
                n.scratch.clear();
                for r in 0..rows {
                    let at = i.at as usize + r * size;
                    for c in 0..size {
                        let mut sum = 0.0;
                        for e in 0..size {
                            sum += n.a[at + e] * n.a[d + e * size + c];
                        }
                        n.scratch.push(sum);
                    }
                }
                for j in &column[..=m] {
                    let to = self.targets[target] as usize;
                    target += 1;
                    let columns = n.size(j.row);
                    for r in 0..rows {
                        for c in 0..columns {
                            let mut sum = 0.0;
                            for e in 0..size {
                                sum += n.scratch[r * size + e] * n.a[j.at as usize + c * size + e];
                            }
                            n.a[to + r * columns + c] -= sum;
                        }
                    }
                }
            }
        }
    }
    /// Does any joint close a loop?
    pub fn has_loops(&self) -> bool {
        self.looped.contains(&true)
    }
    /// Do others hold together what this joint holds together?
    pub fn closes_loop(&self, joint: usize) -> bool {
        self.closes[self.position[joint] as usize]
    }
    /// Sets the right side of a row.
    pub fn set(&self, n: &mut Numbers, joint: usize, row: usize, value: f64) {
        n.x[self.first[self.position[joint] as usize] as usize + row] = value;
    }
    /// λ of a row, after [`Plan::solve`].
    pub fn get(&self, n: &Numbers, joint: usize, row: usize) -> f64 {
        n.x[self.first[self.position[joint] as usize] as usize + row]
    }
    /// Right side to λ.
    pub fn solve(&self, n: &mut Numbers) {
        let mut z = [0.0; ROWS];
        for k in 0..self.order.len() {
            let size = n.size(k as u32);
            self.times_inverse(n, k, &mut z);
            for b in self.column(k) {
                let y = self.first[b.row as usize] as usize;
                for r in 0..n.size(b.row) {
                    let mut sum = 0.0;
                    for (c, z) in z[..size].iter().enumerate() {
                        sum += n.a[b.at as usize + r * size + c] * z;
                    }
                    n.x[y + r] -= sum;
                }
            }
        }
        for k in (0..self.order.len()).rev() {
            let (size, x) = (n.size(k as u32), self.first[k] as usize);
            for b in self.column(k) {
                let y = self.first[b.row as usize] as usize;
                for r in 0..n.size(b.row) {
                    let l = n.x[y + r];
                    for c in 0..size {
                        n.x[x + c] -= n.a[b.at as usize + r * size + c] * l;
                    }
                }
            }
            self.times_inverse(n, k, &mut z);
            n.x[x..x + size].copy_from_slice(&z[..size]);
        }
    }
    fn times_inverse(&self, n: &Numbers, k: usize, z: &mut [f64; ROWS]) {
        let (size, x, d) = (n.size(k as u32), self.first[k] as usize, self.diagonal[k] as usize);
        for r in 0..size {
            let mut sum = 0.0;
            for c in 0..size {
                sum += n.a[d + r * size + c] * n.x[x + c];
            }
            z[r] = sum;
        }
    }
}

/// Which joints are part of a loop: those that close one, and those of the tree on the way between its two bodies.
fn looped(links: &[(u8, [u32; 2])], closes: &[bool], still: u32) -> Vec<bool> {
    let mut looped = closes.to_vec();
    if !closes.contains(&true) {
        return looped;
    }
    let ends = |i: usize| links[i].1.map(|b| b.min(still) as usize);
    let mut next = vec![Vec::new(); still as usize + 1];
    for i in (0..links.len()).filter(|&i| !closes[i]) {
        let [a, b] = ends(i);
        next[a].push((i, b));
        next[b].push((i, a));
    }
    // Each body's joint towards its root, the body there, and how many they are.
    let mut up: Vec<Option<(usize, usize, u32)>> = vec![None; next.len()];
    for start in 0..next.len() {
        if up[start].is_some() {
            continue;
        }
        up[start] = Some((usize::MAX, start, 0));
        let mut list = vec![start];
        while let Some(b) = list.pop() {
            let depth = up[b].map_or(0, |u| u.2);
            for &(i, to) in &next[b] {
                if up[to].is_none() {
                    up[to] = Some((i, b, depth + 1));
                    list.push(to);
                }
            }
        }
    }
    for i in (0..links.len()).filter(|&i| closes[i]) {
        let [mut a, mut b] = ends(i);
        while let (true, Some(x), Some(y)) = (a != b, up[a], up[b]) {
            let (joint, to, _) = if x.2 >= y.2 { x } else { y };
            looped[joint] = true;
            (a, b) = if x.2 >= y.2 { (to, b) } else { (a, to) };
        }
    }
    looped
}

/// Order of least degree (ties to the lower joint), and for each step the joints below.
fn eliminate(n: usize, at_body: &[Vec<u32>], most: usize) -> Option<(Vec<u32>, Vec<Vec<u32>>)> {
    use std::collections::BTreeSet;
    let mut near = vec![BTreeSet::new(); n];
    let mut count = 0;
    for list in at_body {
        count += list.len() * list.len() / 2;
        if count > 4 * most + 64 {
            return None;
        }
        for &i in list {
            near[i as usize].extend(list.iter().copied().filter(|&j| j != i));
        }
    }
    let mut queue: BTreeSet<(usize, u32)> = (0..n as u32).map(|i| (near[i as usize].len(), i)).collect();
    let (mut order, mut columns, mut blocks) = (Vec::with_capacity(n), Vec::with_capacity(n), 0);
    while let Some((_, k)) = queue.pop_first() {
        let column: Vec<u32> = core::mem::take(&mut near[k as usize]).into_iter().collect();
        blocks += column.len();
        if blocks > most {
            return None;
        }
        for &i in &column {
            queue.remove(&(near[i as usize].len(), i));
            near[i as usize].remove(&k);
            near[i as usize].extend(column.iter().copied().filter(|&j| j != i));
            queue.insert((near[i as usize].len(), i));
        }
        order.push(k);
        columns.push(column);
    }
    Some((order, columns))
}

/// Inverse of a small symmetric matrix in place, by elimination without exchange; a vanishing pivot gives zeros.
pub(crate) fn invert(a: &mut [f64], n: usize) {
    // L D Lᵀ below the diagonal.
    let mut l = [0.0; ROWS * ROWS];
    let mut d = [0.0; ROWS];
    for j in 0..n {
        let whole = a[j * n + j];
        let mut pivot = whole;
        for k in 0..j {
            pivot -= l[j * ROWS + k] * l[j * ROWS + k] * d[k];
        }
        let holds = pivot > PIVOT_MIN * whole && pivot > 0.0;
        let inv = if holds { 1.0 / pivot } else { 0.0 };
        d[j] = if holds { pivot } else { 0.0 };
        for i in j + 1..n {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= l[i * ROWS + k] * l[j * ROWS + k] * d[k];
            }
            l[i * ROWS + j] = sum * inv;
        }
    }
    // Columns of the inverse: L y = e, D z = y, Lᵀ x = z.
    for c in 0..n {
        let mut x = [0.0; ROWS];
        for i in c..n {
            let mut sum = if i == c { 1.0 } else { 0.0 };
            for k in c..i {
                sum -= l[i * ROWS + k] * x[k];
            }
            x[i] = sum;
        }
        for i in 0..n {
            x[i] = if d[i] > 0.0 { x[i] / d[i] } else { 0.0 };
        }
        for i in (0..n).rev() {
            if d[i] == 0.0 {
                x[i] = 0.0;
                continue;
            }
            for k in i + 1..n {
                x[i] -= l[k * ROWS + i] * x[k];
            }
        }
        for i in 0..n {
            a[i * n + c] = x[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plan's result against the matrix written out.
    fn check(links: &[(u8, [u32; 2])], bodies: usize) {
        let plan = Plan::new(links, bodies, 10_000).unwrap();
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f64 / (1 << 23) as f64 - 1.0
        };
        // J with random rows, M = 1: A = J Jᵀ.
        let j: Vec<Vec<[[f64; 6]; 2]>> = links
            .iter()
            .map(|l| (0..l.0).map(|_| [0, 1].map(|_| [0; 6].map(|_| random()))).collect())
            .collect();
        let mut n = Numbers::default();
        plan.reserve(&mut n);
        plan.clear(&mut n, |j| usize::from(links[j].0));
        let entry = |i: usize, r: usize, k: usize, c: usize| {
            let mut sum = 0.0;
            for s in 0..2 {
                for t in 0..2 {
                    if links[i].1[s] != u32::MAX && links[i].1[s] == links[k].1[t] {
                        sum += (0..6).map(|x| j[i][r][s][x] * j[k][c][t][x]).sum::<f64>();
                    }
                }
            }
            sum
        };
        for i in 0..links.len() {
            for k in 0..=i {
                let share = links[i].1.iter().any(|b| *b != u32::MAX && links[k].1.contains(b));
                if share {
                    plan.add(&mut n, i, k, |r, c| entry(i, r, k, c));
                }
            }
        }
        plan.factor(&mut n, false);
        let rhs: Vec<Vec<f64>> = links.iter().map(|l| (0..l.0).map(|_| random()).collect()).collect();
        for (i, r) in rhs.iter().enumerate() {
            for (row, v) in r.iter().enumerate() {
                plan.set(&mut n, i, row, *v);
            }
        }
        plan.solve(&mut n);
        for (i, r) in rhs.iter().enumerate() {
            for (row, v) in r.iter().enumerate() {
                let mut sum = 0.0;
                for (k, l) in links.iter().enumerate() {
                    for c in 0..usize::from(l.0) {
                        let own = k == i && c == row;
                        let gives = if own { plan.gives(plan.position[i] as usize, false) } else { 0.0 };
                        sum += (1.0 + gives) * entry(i, row, k, c) * plan.get(&n, k, c);
                    }
                }
                assert!((sum - v).abs() < 1e-8, "joint {i}, row {row}: {sum} for {v}");
            }
        }
    }

    #[test]
    fn chains_trees_and_loops_are_solved() {
        let none = u32::MAX;
        check(&[(3, [none, 0])], 1);
        check(&[(3, [none, 0]), (3, [0, 1]), (5, [1, 2]), (6, [2, 3]), (1, [3, 4])], 5);
        check(&[(3, [0, 1]), (3, [0, 2]), (3, [0, 3]), (5, [3, 4]), (5, [2, 5])], 6);
        check(&[(2, [0, 1]), (2, [1, 2]), (2, [2, 3]), (2, [3, 0])], 4);
    }

    #[test]
    fn chains_do_not_fill_in() {
        let links: Vec<(u8, [u32; 2])> = (0..200).map(|i| (3, [i, i + 1])).collect();
        let plan = Plan::new(&links, 201, 199).unwrap();
        assert_eq!(plan.below.len(), 199);
        assert!(Plan::new(&links, 201, 198).is_none());
    }

    #[test]
    fn a_superfluous_row_gives_way() {
        let mut a = [2.0, 2.0, 2.0, 2.0];
        invert(&mut a, 2);
        assert_eq!(a, [0.5, 0.0, 0.0, 0.0]);
    }
}
