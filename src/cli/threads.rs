//! How many threads learning and reaching have.

use rayon::ThreadPoolBuilder;

/// Threads at the most where there are not as many cores: 1,024 on two cores wait for each other ten times as long as they work.
const MOST: usize = 64;

/// Makes the threads: as many as `RAYON_NUM_THREADS` says or there are cores, or as many as the system gives. Their number
/// changes nothing but the time.
pub fn make() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
    let mut count = asked.filter(|count| *count > 0).unwrap_or(cores).min(cores.max(MOST));
    // The pool of all can be tried but once.
    while count > 1 && builder(count).build().is_err() {
        count /= 2;
    }
    let pool = builder(count);
    // One thread is there already.
    let pool = if count == 1 { pool.use_current_thread() } else { pool };
    // Where there is a pool already, that one is used.
    let _ = pool.build_global();
}

fn builder(count: usize) -> ThreadPoolBuilder {
    ThreadPoolBuilder::new().num_threads(count)
}
