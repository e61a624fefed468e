//! Maps in order, shared among the threads of the pool that calls: results do not depend on their number.

use super::shared_work::SharedWork;
use rayon::prelude::*;

/// Returns true on a thread of a pool. Elsewhere the global pool of rayon would start threads that nobody ends.
fn is_in_pool() -> bool {
    rayon::current_thread_index().is_some()
}

/// Maps each item, in order, with at least `least` items on a thread.
pub fn map_in_order<T: Sync, R: Send>(items: &[T], least: usize, map: impl Fn(&T) -> R + Sync) -> Vec<R> {
    map_in_order_with(items, least, || (), |(), item| map(item))
}

/// Maps each item, in order, with at least `least` items on a thread, which has a workspace made by `new`.
pub fn map_in_order_with<T: Sync, R: Send, W>(
    items: &[T],
    least: usize,
    new: impl Fn() -> W + Sync,
    map: impl Fn(&mut W, &T) -> R + Sync,
) -> Vec<R> {
    if !is_in_pool() || items.len() < 2 * least {
        let mut workspace = new();
        return items.iter().map(|item| map(&mut workspace, item)).collect();
    }
    let new = || (SharedWork::begin(), new());
    items.par_iter().with_min_len(least).map_init(new, |(_, workspace), item| map(workspace, item)).collect()
}

/// Maps each chunk of `size` items, the last of which may be shorter, in order; `map` is given the number of the first item.
pub fn map_chunks_in_order<T: Send, R: Send>(
    items: &mut [T],
    size: usize,
    map: impl Fn(usize, &mut [T]) -> R + Sync,
) -> Vec<R> {
    let map = |(chunk, items): (usize, &mut [T])| map(chunk * size, items);
    if !is_in_pool() {
        return items.chunks_mut(size).enumerate().map(map).collect();
    }
    let shared = |chunk| {
        let _work = SharedWork::begin();
        map(chunk)
    };
    items.par_chunks_mut(size).enumerate().map(shared).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_keep_the_order_in_and_outside_of_a_pool() {
        let items: Vec<usize> = (0..1000).collect();
        let run = || {
            let squares = map_in_order_with(
                &items,
                8,
                || 0,
                |calls, item| {
                    *calls += 1;
                    item * item
                },
            );
            let mut chunked = items.clone();
            let firsts = map_chunks_in_order(&mut chunked, 64, |first, chunk| {
                for item in chunk {
                    *item += 1;
                }
                first
            });
            (squares, map_in_order(&items, 8, |item| item + 1), chunked, firsts)
        };
        let (squares, next, chunked, firsts) = run();
        assert!(squares.iter().zip(&items).all(|(square, item)| *square == item * item));
        assert!(next == chunked && next.iter().zip(&items).all(|(next, item)| *next == item + 1));
        assert_eq!(firsts, (0..1000).step_by(64).collect::<Vec<_>>());
        for n_threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("threads can be started");
            assert_eq!(pool.install(run), (squares.clone(), next.clone(), chunked.clone(), firsts.clone()));
        }
    }
}
