//! Large pages for large arrays: fewer of them to look up while an array is gathered from.

/// Room below which nothing is asked for: some large pages.
#[cfg(target_os = "linux")]
const WORTH_IT: usize = 8 << 20;

/// Asks the system to back the unused capacity of `v` by large pages, where it can; to be called
/// before the first entry is written. Nothing but speed depends on it.
pub fn large_pages<T>(v: &mut Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        let room = v.spare_capacity_mut();
        let bytes = size_of_val(room);
        let page = rustix::param::page_size();
        let first = room.as_mut_ptr().cast::<u8>();
        let skip = first.align_offset(page);
        if bytes >= WORTH_IT && skip < bytes {
            let whole = (bytes - skip) / page * page;
            // SAFETY: the pages lie within the allocation of `v`, which is borrowed mutably, and
            // the advice changes how they are mapped, not what they hold.
            #[allow(unsafe_code)]
            let advised = unsafe {
                let advice = rustix::mm::Advice::LinuxHugepage;
                rustix::mm::madvise(first.add(skip).cast(), whole, advice)
            };
            // A system without large pages does as well, a little slower.
            let _ = advised;
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = v;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_stays() {
        let mut v: Vec<u32> = Vec::with_capacity(10 << 20);
        v.extend(0..1000);
        large_pages(&mut v);
        v.extend(1000..4 << 20);
        assert!(v.iter().enumerate().all(|(i, x)| i == *x as usize));
        large_pages(&mut Vec::<u8>::new());
    }
}
