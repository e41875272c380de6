//! Optimisers: one trait, one file each, all bounded to the unit box and all seeded.
