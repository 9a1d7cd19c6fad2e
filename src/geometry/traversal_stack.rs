//! The children that a traversal has yet to visit.

/// Entries that need no memory of their own: few, since they are cleared for each ray, and a power of two.
const LEN: usize = 32;

/// Children yet to be visited with the distance at which the ray enters them, which is not negative. A tree so deep that it
/// does not fit spills to the heap.
pub(super) struct TraversalStack {
    /// The bits of the distance above those of the child: numbers in the order of the distances.
    entries: [u64; LEN],
    /// At most [`LEN`].
    len: usize,
    /// Above the entries, once all are taken.
    spilled: Vec<u64>,
}

impl TraversalStack {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { entries: [0; LEN], len: 0, spilled: Vec::new() }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// An entry below [`LEN`], which the remainder tells the compiler.
    #[inline(always)]
    fn entry(&mut self, at: usize) -> &mut u64 {
        &mut self.entries[at % LEN]
    }

    /// Inserts so that the entries from `base` on are sorted, the nearest last.
    #[inline(always)]
    pub(super) fn push_sorted(&mut self, base: usize, near: f32, child: u32) {
        let new = u64::from(near.to_bits()) << 32 | u64::from(child);
        if self.len == LEN {
            self.spilled.push(new);
            return;
        }
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

    /// The distance and the child on top.
    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<(f32, u32)> {
        let entry = if self.len == LEN && !self.spilled.is_empty() {
            self.spilled.pop()?
        } else {
            self.len = self.len.checked_sub(1)?;
            *self.entry(self.len)
        };
        Some((f32::from_bits((entry >> 32) as u32), entry as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_each_node_comes_first_and_nothing_is_lost() {
        let mut stack = TraversalStack::new();
        let nears = [3.0, 1.0, 4.0, 1.5, 9.0, 2.6];
        // Nodes of six children: the first five fit, the sixth spills in part.
        for node in 0..7 {
            let base = stack.len();
            for (child, near) in (0..).zip(nears) {
                stack.push_sorted(base, near, 10 * node + child);
            }
        }
        let popped: Vec<_> = std::iter::from_fn(|| stack.pop()).collect();
        assert_eq!(popped.len(), 7 * nears.len());
        let mut children: Vec<_> = popped.iter().map(|entry| entry.1).collect();
        children.sort_unstable();
        assert_eq!(children, (0..7).flat_map(|node| (0..6).map(move |child| 10 * node + child)).collect::<Vec<_>>());
        for node in popped[12..].chunks(6) {
            assert!(node.is_sorted_by(|a, b| a.0 <= b.0), "{node:?}");
        }
        assert_eq!(stack.pop(), None);
    }
}
