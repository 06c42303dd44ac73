#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| foldrs_fuzz::template(data));
