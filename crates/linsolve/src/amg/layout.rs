//! Where the rows of a level go: blocks of a fixed number of slots; within a block rows of one
//! colour (no two of them coupled) side by side, so that 16 consecutive ones can be swept at once.

use super::graph::{Graph, NONE, clear, fill};

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
    /// Block and colour of each row.
    colour: Vec<(u32, u32)>,
    /// The rows of a block by what makes them alike, then by their place in the block.
    sorted: Vec<(u64, u32)>,
}

impl Layout {
    /// Cuts `order` (every row once; close together what is strongly coupled) into blocks and
    /// colours the rows of each.
    pub(crate) fn build(&mut self, g: &Graph, order: &[u32]) {
        // Rows per block, leaving room to pad each colour to whole lanes; at last so many colours
        // that padding does not pay: one row in each group of lanes.
        let sizes = [1984, 1920, 1792, 1536, 1024, 512, SLOTS / LANES];
        let _ = sizes.into_iter().any(|rows| self.fits(g, order, rows));
    }

    fn fits(&mut self, g: &Graph, order: &[u32], rows: usize) -> bool {
        let n = g.rows();
        let Layout { row, slot, colour, sorted } = self;
        clear(row, n.div_ceil(rows) * SLOTS);
        fill(slot, n, NONE);
        fill(colour, n, (NONE, 0));
        clear(sorted, rows);
        for (block, members) in order.chunks(rows).enumerate() {
            let number = block as u32;
            for &i in members {
                let mut used = 0u128;
                for (j, _) in g.row(i as usize) {
                    if colour[j].0 == number {
                        used |= 1 << colour[j].1;
                    }
                }
                // The last colour takes what is left; such rows see each other's old values.
                colour[i as usize] = (number, used.trailing_ones().min(127));
            }
            sorted.clear();
            for (k, &i) in members.iter().enumerate() {
                // Rows with as many couplings of each kind side by side: less padding.
                let own = colour[i as usize];
                let (mut lower, mut upper, mut outer) = (0u64, 0u64, 0u64);
                for (j, _) in g.row(i as usize) {
                    match colour[j] {
                        (b, _) if b != number => outer += 1,
                        (_, c) if c < own.1 => lower += 1,
                        _ => upper += 1,
                    }
                }
                let alike = (u64::from(own.1) << 24) | (outer.min(255) << 16);
                let alike = alike | (lower.min(255) << 8) | upper.min(255);
                sorted.push(((alike << 32) | k as u64, i));
            }
            sorted.sort_unstable();
            let mut before = NONE;
            for &(_, i) in sorted.iter() {
                if colour[i as usize].1 != before {
                    row.resize(row.len().next_multiple_of(LANES), NONE);
                    before = colour[i as usize].1;
                }
                slot[i as usize] = row.len() as u32;
                row.push(i);
            }
            row.resize(row.len().next_multiple_of(LANES), NONE);
            let full = (block + 1) * SLOTS;
            if row.len() > full {
                return false;
            }
            if (block + 1) * rows < n {
                row.resize(full, NONE);
            }
        }
        true
    }
}
