//! Where the rows of a level go: blocks of a fixed number of slots; within a block rows of one
//! colour (no two of them coupled) side by side, so that 16 consecutive ones can be swept at once.

use super::graph::{Graph, NONE};

/// Slots per block. Gauss-Seidel inside, Jacobi between blocks, for any number of threads.
pub(crate) const SLOTS: usize = 2048;
/// Rows swept together.
pub(crate) const LANES: usize = 16;

/// The order of a level's rows.
#[derive(Debug, Default)]
pub(crate) struct Layout {
    /// Row in each slot, [`NONE`] for padding; a multiple of [`LANES`] long.
    pub(crate) row: Vec<u32>,
    /// Slot of each row.
    pub(crate) slot: Vec<u32>,
}

impl Layout {
    /// Cuts `order` (every row once; close together what is strongly coupled) into blocks and
    /// colours the rows of each.
    pub(crate) fn new(g: &Graph, order: &[u32]) -> Layout {
        // Rows per block, leaving room to pad each colour to whole lanes.
        for rows in [1984, 1920, 1792, 1536, 1024, 512] {
            if let Some(l) = Layout::with(g, order, rows) {
                return l;
            }
        }
        // So many colours that padding does not pay: one row in each group of lanes.
        Layout::with(g, order, SLOTS / LANES).unwrap_or_default()
    }

    fn with(g: &Graph, order: &[u32], rows: usize) -> Option<Layout> {
        let n = g.rows();
        let mut l = Layout { row: Vec::new(), slot: vec![NONE; n] };
        // Block and colour of the rows done so far.
        let mut colour = vec![(NONE, 0u32); n];
        let mut sorted: Vec<u32> = Vec::new();
        for (block, members) in order.chunks(rows).enumerate() {
            let block = block as u32;
            for &i in members {
                let mut used = 0u128;
                for (j, _) in g.row(i as usize) {
                    if colour[j].0 == block {
                        used |= 1 << colour[j].1;
                    }
                }
                // The last colour takes what is left; such rows see each other's old values.
                colour[i as usize] = (block, used.trailing_ones().min(127));
            }
            sorted.clear();
            sorted.extend_from_slice(members);
            // Rows of one length side by side: less padding.
            sorted.sort_by_key(|&i| (colour[i as usize].1, g.entries(i as usize).len()));
            let mut before = NONE;
            for &i in &sorted {
                if colour[i as usize].1 != before {
                    l.row.resize(l.row.len().next_multiple_of(LANES), NONE);
                    before = colour[i as usize].1;
                }
                l.slot[i as usize] = l.row.len() as u32;
                l.row.push(i);
            }
            l.row.resize(l.row.len().next_multiple_of(LANES), NONE);
            let full = (block as usize + 1) * SLOTS;
            if l.row.len() > full {
                return None;
            }
            if (block as usize + 1) * rows < n {
                l.row.resize(full, NONE);
            }
        }
        Some(l)
    }
}
