//! One seam for the widest vector registers there are.
//!
//! A program for all processors of a kind may use only what the oldest of them has. The loops that time goes to are
//! compiled for AVX2 as well, and the better version is chosen when they run. Both do the same arithmetic in the same
//! order, without fused steps: results do not depend on the processor.

/// A loop that time goes to.
///
/// Only what is inlined into it profits: [`Kernel::run`] and all it calls must be marked `#[inline(always)]`. (A
/// closure would be called, not inlined.)
pub(crate) trait Kernel {
    type Output;
    fn run(self) -> Self::Output;
}

/// Runs a kernel with the widest registers this processor has.
#[inline]
pub(crate) fn widest<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(Dispatched(kernel))
}

struct Dispatched<K>(K);

impl<K: Kernel> pulp::NullaryFnOnce for Dispatched<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run()
    }
}
