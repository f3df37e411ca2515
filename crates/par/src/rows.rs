//! Loops over the rows of ragged arrays.

use crate::Exec;

impl Exec {
    /// Calls `f(first_row, values, out)` on disjoint runs of rows: `out` holds one entry a row and
    /// row `i` owns `values[ptr[i]..ptr[i + 1]]`. The slice `values` handed to `f` starts at
    /// `ptr[first_row]`.
    ///
    /// # Panics
    /// When `ptr` does not describe `values` and `out`.
    pub fn for_each_row<A: Send, B: Send>(
        &self,
        ptr: &[u32],
        values: &mut [A],
        out: &mut [B],
        f: impl Fn(usize, &mut [A], &mut [B]) + Sync,
    ) {
        let n = out.len();
        assert_eq!(ptr.len(), n + 1, "one pointer a row and one at the end");
        assert_eq!(ptr[n] as usize, values.len(), "the pointers end where the values do");
        assert!(ptr.is_sorted(), "rows follow each other");
        let whole = SharedSlice(values.as_mut_ptr());
        let whole = &whole;
        self.for_each(out, |first, out| {
            let (lo, hi) = (ptr[first] as usize, ptr[first + out.len()] as usize);
            // SAFETY: chunks of `out` are disjoint runs of rows and `ptr` is sorted and in bounds
            // (checked above), so the ranges of `values` are disjoint too; `values` is borrowed
            // for the whole call.
            #[allow(unsafe_code)]
            let values = unsafe { std::slice::from_raw_parts_mut(whole.0.add(lo), hi - lo) };
            f(first, values, out);
        });
    }
}

/// A pointer whose disjoint parts go to different threads.
struct SharedSlice<T>(*mut T);
// SAFETY: every thread gets a range of its own, and `T: Send`.
#[allow(unsafe_code)]
unsafe impl<T: Send> Sync for SharedSlice<T> {}

#[cfg(test)]
mod tests {
    use crate::{Exec, Solo};

    #[test]
    fn every_row_gets_its_own_values() {
        let rows = 5000;
        let ptr: Vec<u32> = (0..=rows).map(|i| (i * (i % 2 + 1) / 2 * 2) as u32).collect();
        let mut ptr = ptr;
        ptr.sort_unstable();
        let n = ptr[rows] as usize;
        for threads in [1, 3] {
            let exec = Exec::new(threads, Box::new(Solo));
            let (mut values, mut sum) = (vec![1.0; n], vec![0.0; rows]);
            exec.for_each_row(&ptr, &mut values, &mut sum, |first, v, out| {
                let base = ptr[first] as usize;
                for (i, s) in out.iter_mut().enumerate() {
                    let (lo, hi) =
                        (ptr[first + i] as usize - base, ptr[first + i + 1] as usize - base);
                    v[lo..hi].iter_mut().for_each(|x| *x += i as f64 * 0.0 + 1.0);
                    *s = v[lo..hi].iter().sum();
                }
            });
            assert!(values.iter().all(|v| *v == 2.0));
            assert_eq!(sum[7], 2.0 * f64::from(ptr[8] - ptr[7]));
        }
    }
}
