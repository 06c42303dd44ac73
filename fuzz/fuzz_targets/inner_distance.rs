#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| foldrs_fuzz::inner_distance(data));
