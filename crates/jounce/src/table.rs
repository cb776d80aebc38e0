//! Slot tables with generations, and the set of shape pairs.

/// Slots that are reused after removal under a new generation.
#[derive(Clone, Debug)]
pub(crate) struct Table<T> {
    entries: Vec<Entry<T>>,
    free: Vec<u32>,
    live: usize,
}

#[derive(Clone, Debug)]
pub(crate) struct Entry<T> {
    generation: u32,
    value: Option<T>,
}

impl<T> Entry<T> {
    /// The value, if the slot is live.
    pub fn get_mut(&mut self) -> Option<&mut T> {
        self.value.as_mut()
    }
}

impl<T> Default for Table<T> {
    fn default() -> Self {
        Self { entries: Vec::new(), free: Vec::new(), live: 0 }
    }
}

impl<T> Table<T> {
    /// Adds a value and gives (index, generation). A slot whose generation is spent is never reused.
    pub fn insert(&mut self, value: T) -> (u32, u32) {
        self.live += 1;
        if let Some(index) = self.free.pop() {
            let e = &mut self.entries[index as usize];
            e.value = Some(value);
            return (index, e.generation);
        }
        let index = self.entries.len() as u32;
        self.entries.push(Entry { generation: 1, value: Some(value) });
        (index, 1)
    }
    pub fn remove(&mut self, index: u32) -> Option<T> {
        let e = self.entries.get_mut(index as usize)?;
        let value = e.value.take()?;
        self.live -= 1;
        if e.generation < u32::MAX {
            e.generation += 1;
            self.free.push(index);
        }
        Some(value)
    }
    /// Is this index live under this generation?
    pub fn is_live(&self, index: u32, generation: u32) -> bool {
        self.entries.get(index as usize).is_some_and(|e| e.generation == generation && e.value.is_some())
    }
    pub fn generation(&self, index: u32) -> u32 {
        self.entries.get(index as usize).map_or(0, |e| e.generation)
    }
    pub fn get(&self, index: u32) -> Option<&T> {
        self.entries.get(index as usize).and_then(|e| e.value.as_ref())
    }
    pub fn get_mut(&mut self, index: u32) -> Option<&mut T> {
        self.entries.get_mut(index as usize).and_then(|e| e.value.as_mut())
    }
    /// All slots, by index.
    pub fn entries_mut(&mut self) -> &mut [Entry<T>] {
        &mut self.entries
    }
    /// Asks for the memory of a slot that will be read soon.
    pub fn call(&self, index: u32) {
        if let Some(e) = self.entries.get(index as usize) {
            jounce_lanes::prefetch(e);
        }
    }
    /// Slots that were ever used.
    pub fn slots(&self) -> u32 {
        self.entries.len() as u32
    }
    pub fn len(&self) -> usize {
        self.live
    }
    /// Live entries in slot order.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.entries.iter().enumerate().filter_map(|(i, e)| e.value.as_ref().map(|v| (i as u32, v)))
    }
    /// Live values in slot order, to change.
    pub fn values_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.entries.iter_mut().filter_map(|e| e.value.as_mut())
    }
    /// What the next handles depend on: the free list and the generations.
    pub fn allocator_words(&self) -> impl Iterator<Item = u32> + '_ {
        self.free.iter().copied().chain(self.entries.iter().map(|e| e.generation))
    }
}

/// Panics on a dead slot: engine code only names slots it knows to be live.
impl<T> core::ops::Index<u32> for Table<T> {
    type Output = T;
    fn index(&self, index: u32) -> &T {
        match &self.entries[index as usize].value {
            Some(v) => v,
            None => dead_slot(index),
        }
    }
}

impl<T> core::ops::IndexMut<u32> for Table<T> {
    fn index_mut(&mut self, index: u32) -> &mut T {
        match &mut self.entries[index as usize].value {
            Some(v) => v,
            None => dead_slot(index),
        }
    }
}

#[cold]
fn dead_slot(index: u32) -> ! {
    unreachable!("slot {index} is not live: an engine table is inconsistent")
}

/// A set of shape pairs, each with its contact's id. Open addressing with backward-shift deletion. It is asked
/// for membership only and never iterated, so its layout is not state.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairMap {
    slots: Vec<(u64, u32)>,
    len: usize,
}

const EMPTY: u64 = u64::MAX;

/// Key of a pair; the lower index first.
pub(crate) fn pair_key(a: u32, b: u32) -> u64 {
    let (lo, hi) = if a < b { (a, b) } else { (b, a) };
    (u64::from(lo) << 32) | u64::from(hi)
}

impl PairMap {
    fn home(&self, key: u64) -> usize {
        let h = key.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((h ^ (h >> 32)) as usize) & (self.slots.len() - 1)
    }
    fn find(&self, key: u64) -> Option<usize> {
        if self.slots.is_empty() {
            return None;
        }
        let mask = self.slots.len() - 1;
        let mut i = self.home(key);
        loop {
            match self.slots[i].0 {
                k if k == key => return Some(i),
                EMPTY => return None,
                _ => i = (i + 1) & mask,
            }
        }
    }
    pub fn contains(&self, key: u64) -> bool {
        self.find(key).is_some()
    }
    pub fn get(&self, key: u64) -> Option<u32> {
        self.find(key).map(|i| self.slots[i].1)
    }
    pub fn insert(&mut self, key: u64, value: u32) {
        if (self.len + 1) * 2 > self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        let mut i = self.home(key);
        while self.slots[i].0 != EMPTY && self.slots[i].0 != key {
            i = (i + 1) & mask;
        }
        if self.slots[i].0 == EMPTY {
            self.len += 1;
        }
        self.slots[i] = (key, value);
    }
    pub fn remove(&mut self, key: u64) {
        let Some(mut hole) = self.find(key) else { return };
        let mask = self.slots.len() - 1;
        self.len -= 1;
        let mut i = (hole + 1) & mask;
        while self.slots[i].0 != EMPTY {
            let home = self.home(self.slots[i].0);
            // Move the entry back when its home is not between the hole and itself.
            if (i.wrapping_sub(home) & mask) >= (i.wrapping_sub(hole) & mask) {
                self.slots[hole] = self.slots[i];
                hole = i;
            }
            i = (i + 1) & mask;
        }
        self.slots[hole].0 = EMPTY;
    }
    pub fn len(&self) -> usize {
        self.len
    }
    fn grow(&mut self) {
        let old = core::mem::take(&mut self.slots);
        self.slots = vec![(EMPTY, 0); (old.len() * 2).max(64)];
        self.len = 0;
        for (k, v) in old.into_iter().filter(|e| e.0 != EMPTY) {
            self.insert(k, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_removed_slot_comes_back_under_a_new_generation() {
        let mut t = Table::default();
        let (i, g) = t.insert('a');
        t.remove(i);
        assert!(!t.is_live(i, g));
        let (j, h) = t.insert('b');
        assert_eq!(i, j);
        assert_ne!(g, h);
        assert!(t.get(i) == Some(&'b') && !t.is_live(i, g) && t.is_live(j, h));
    }

    #[test]
    fn a_spent_generation_retires_its_slot() {
        let mut t = Table::default();
        let (i, _) = t.insert(0);
        t.entries[i as usize].generation = u32::MAX;
        t.remove(i);
        assert_ne!(t.insert(1).0, i);
    }

    #[test]
    fn pair_map_agrees_with_a_model() {
        let mut map = PairMap::default();
        let mut model = std::collections::BTreeMap::new();
        let mut s = 1u64;
        for _ in 0..60_000 {
            s = s.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let key = pair_key(((s >> 33) % 40) as u32, ((s >> 40) % 40) as u32);
            if s >> 63 == 0 {
                map.insert(key, (s >> 20) as u32);
                model.insert(key, (s >> 20) as u32);
            } else {
                map.remove(key);
                model.remove(&key);
            }
            assert_eq!(map.get(key), model.get(&key).copied());
            assert_eq!(map.len(), model.len());
        }
        for (k, v) in &model {
            assert_eq!(map.get(*k), Some(*v));
        }
    }
}
