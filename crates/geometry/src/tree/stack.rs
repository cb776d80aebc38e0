//! The stack of a traversal.

/// A fixed array, and behind it a vector for trees deeper than any builder makes: no depth overflows it, and
/// the usual one allocates nothing.
pub(super) struct Stack<T> {
    fixed: [T; FIXED],
    len: usize,
    spill: Vec<T>,
}

/// Depth that costs no allocation.
const FIXED: usize = 64;

impl<T: Copy> Stack<T> {
    #[inline(always)]
    pub fn new(filler: T) -> Self {
        Self { fixed: [filler; FIXED], len: 0, spill: Vec::new() }
    }
    #[inline(always)]
    pub fn push(&mut self, item: T) {
        if self.len < FIXED {
            self.fixed[self.len] = item;
            self.len += 1;
        } else {
            self.spill.push(item);
        }
    }
    #[inline(always)]
    pub fn pop(&mut self) -> Option<T> {
        if !self.spill.is_empty() {
            return self.spill.pop();
        }
        self.len = self.len.checked_sub(1)?;
        Some(self.fixed[self.len])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_in_first_out_far_beyond_the_fixed_part() {
        let mut s = Stack::new(0);
        for round in 0..3 {
            (0..200).for_each(|i| s.push(i + round));
            (100..200).rev().for_each(|i| assert_eq!(s.pop(), Some(i + round)));
            s.push(7);
            assert_eq!(s.pop(), Some(7));
            (0..100).rev().for_each(|i| assert_eq!(s.pop(), Some(i + round)));
            assert_eq!(s.pop(), None);
        }
    }
}
