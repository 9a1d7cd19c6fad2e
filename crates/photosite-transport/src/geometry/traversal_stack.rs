//! Stack of the children that a traversal has yet to visit.

/// Entries that need no memory of their own: few, since they are cleared for most rays, and a power of two.
const LEN: usize = 32;

/// Pushes between two calls of [`TraversalStack::make_room`], at most.
const ROOM: usize = 8;

/// Children yet to be visited with the distance at which the ray enters them. A tree so deep that they do not fit
/// spills to the heap.
pub(super) struct TraversalStack {
    entries: [Entry; LEN],
    /// Number of entries, at most [`LEN`].
    len: usize,
    /// Entries that have been spilled, below the others.
    spilled: Vec<Entry>,
}

/// A child with the distance at which the ray enters it, which is not negative: its bits above those of the child, so
/// that the numbers are in the order of the distances.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Entry(u64);

impl Entry {
    #[inline(always)]
    pub(super) fn new(near: f32, child: u32) -> Self {
        Self(u64::from(near.to_bits()) << 32 | u64::from(child))
    }

    #[inline(always)]
    pub(super) fn near(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub(super) fn child(self) -> u32 {
        self.0 as u32
    }
}

impl TraversalStack {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { entries: [Entry(0); LEN], len: 0, spilled: Vec::new() }
    }

    /// Removes all entries.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.len = 0;
        self.spilled.clear();
    }

    /// Makes room for the children of the next node.
    #[inline(always)]
    pub(super) fn make_room(&mut self) {
        if self.len > LEN - ROOM {
            self.spill();
        }
    }

    /// Index at which the children of the next node will begin, once there is [room](Self::make_room) for them.
    #[inline(always)]
    pub(super) fn base(&self) -> usize {
        self.len
    }

    #[cold]
    fn spill(&mut self) {
        self.spilled.extend_from_slice(&self.entries[..self.len]);
        self.len = 0;
    }

    /// An entry below [`LEN`], which the remainder tells the compiler.
    #[inline(always)]
    fn entry(&mut self, at: usize) -> &mut Entry {
        &mut self.entries[at % LEN]
    }

    /// Inserts so that the entries from `base` on are sorted, the nearest last.
    #[inline(always)]
    pub(super) fn push_sorted(&mut self, base: usize, new: Entry) {
        let mut at = self.len;
        while at > base {
            let before = *self.entry(at - 1);
            if before >= new {
                break;
            }
            *self.entry(at) = before;
            at -= 1;
        }
        *self.entry(at) = new;
        self.len += 1;
    }

    /// Puts an entry on top.
    #[inline(always)]
    pub(super) fn push(&mut self, new: Entry) {
        *self.entry(self.len) = new;
        self.len += 1;
    }

    /// Takes the entry on top.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Entry> {
        if self.len == 0 {
            return self.spilled.pop();
        }
        self.len -= 1;
        Some(*self.entry(self.len))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_each_node_comes_first_and_nothing_is_lost() {
        let mut stack = TraversalStack::new();
        let nears = [3.0, 1.0, 4.0, 1.5, 9.0, 2.6];
        // Nodes of six children: five fill the entries.
        for node in 0..7 {
            stack.make_room();
            let base = stack.base();
            for (child, near) in (0..).zip(nears) {
                stack.push_sorted(base, Entry::new(near, 10 * node + child));
            }
        }
        let popped: Vec<_> = std::iter::from_fn(|| stack.pop()).map(|entry| (entry.near(), entry.child())).collect();
        assert_eq!(popped.len(), 7 * nears.len());
        let mut children: Vec<_> = popped.iter().map(|entry| entry.1).collect();
        children.sort_unstable();
        assert_eq!(children, (0..7).flat_map(|node| (0..6).map(move |child| 10 * node + child)).collect::<Vec<_>>());
        for node in popped[12..].chunks(6) {
            assert!(node.is_sorted_by(|a, b| a.0 <= b.0), "{node:?}");
        }
        assert!(stack.pop().is_none());
    }
}
