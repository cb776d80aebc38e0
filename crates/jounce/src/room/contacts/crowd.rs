//! Many bodies in one place: a limit on how hard they push each other out.
//!
//! Every deep contact asks its two bodies to part at up to v_push. A body inside many others has as many such wishes, in all
//! directions, and no solution meets them: sweep after sweep each row adds its own, the relaxing pass takes back only a part of
//! it, and a hundred spheres that start at one point fly apart at twenty times v_push.
//!
//! A contact counts as *deep* from half the thickness of its thinner shape (or ten slops) on, which nothing that rests or
//! collides reaches. Where a body has n deep contacts, more than it has room for neighbours around it (12 equal
//! spheres touch one), each of them asks for 12/n of its part: b ← b·12/n, v_push ← v_push·12/n.

use super::state::Contact;
use crate::room::rigid::state::BodyFrame;

/// Depth, in slops of the contact, from which a contact is deep.
pub(crate) const DEEP_SLOPS: f32 = 10.0;
/// Neighbours that have room around a body of their size (the kissing number in three dimensions).
const NEIGHBOURS: f32 = 12.0;

/// Gives those deep contacts (their places in `contacts`) that are left less than all of their push-out, and the part; `counts` is
/// scratch, `rows` the number of awake bodies.
pub(crate) fn share(
    contacts: &[Contact],
    deep: &[u32],
    frames: &[BodyFrame],
    counts: &mut Vec<u32>,
    rows: usize,
    shares: &mut Vec<(u32, f32)>,
) {
    shares.clear();
    if deep.len() <= NEIGHBOURS as usize {
        return;
    }
    counts.clear();
    counts.resize(rows, 0);
    let row = |body: u32| frames[body as usize].row as usize;
    for &i in deep {
        let c = &contacts[i as usize];
        for body in [c.body_a, c.body_b] {
            if let Some(n) = counts.get_mut(row(body)) {
                *n += 1;
            }
        }
    }
    for &i in deep {
        let c = &contacts[i as usize];
        let count = |body: u32| counts.get(row(body)).copied().unwrap_or(0);
        let n = count(c.body_a).max(count(c.body_b)) as f32;
        if n > NEIGHBOURS {
            shares.push((i, NEIGHBOURS / n));
        }
    }
}
