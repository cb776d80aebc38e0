//! A seeded random order of the units of a stage, without a table: a bijection on the next power of two, walked
//! until it lands inside the range (cycle walking; Black and Rogaway, "Ciphers with arbitrary finite domains", 2002).

/// The order of one stage of `units` units.
pub(crate) struct Shuffle {
    key: u64,
    units: u64,
    bits: u32,
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014).
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

impl Shuffle {
    pub(crate) fn new(seed: u64, stage: u64, units: usize) -> Self {
        let units = units as u64;
        let bits = u64::BITS - units.saturating_sub(1).leading_zeros();
        Self { key: mix(seed ^ mix(stage)), units, bits }
    }

    /// The unit that is done `i`-th; a permutation of `0..units`.
    pub(crate) fn unit(&self, i: usize) -> usize {
        let mut x = self.scramble(i as u64);
        while x >= self.units {
            x = self.scramble(x);
        }
        x as usize
    }

    /// A bijection on `0..2^bits`: adding a key, multiplying by an odd number and folding high bits down are each
    /// invertible modulo a power of two.
    fn scramble(&self, mut x: u64) -> u64 {
        if self.bits == 0 {
            return 0;
        }
        let mask = u64::MAX >> (u64::BITS - self.bits);
        let fold = self.bits.div_ceil(2);
        for round in 0..3 {
            let key = mix(self.key.wrapping_add(round));
            x = x.wrapping_add(key) & mask;
            x = x.wrapping_mul((key >> 32) | 1) & mask;
            x ^= x >> fold;
        }
        x
    }

    /// Gives the processor away before about one unit in four.
    pub(crate) fn maybe_yield(&self, i: usize) {
        if mix(self.key ^ i as u64).is_multiple_of(4) {
            std::thread::yield_now();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Shuffle;

    #[test]
    fn every_order_is_a_permutation() {
        for units in (1..70).chain([255, 256, 257, 1000, 4097]) {
            for stage in 0..5 {
                let shuffle = Shuffle::new(7, stage, units);
                let mut seen = vec![false; units];
                for i in 0..units {
                    let unit = shuffle.unit(i);
                    assert!(!std::mem::replace(&mut seen[unit], true), "{unit} of {units} twice");
                }
            }
        }
    }

    #[test]
    fn stages_differ() {
        let order = |stage| (0..100).map(|i| Shuffle::new(1, stage, 100).unit(i)).collect::<Vec<_>>();
        assert_ne!(order(0), order(1));
        assert_ne!(order(0), (0..100).collect::<Vec<_>>());
    }
}
