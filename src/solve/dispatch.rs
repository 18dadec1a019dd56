//! Loops that are compiled twice: for AVX2, and for what every processor of the target has.
//!
//! Both do the same operations in the same order, without contraction, and give the same bits.

/// Makes a function that runs its body, an `#[inline(always)]` function, with the registers that the processor has.
macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $body:ident, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $(#[$doc])*
        pub(crate) fn $name($($arg: $type),*) $(-> $result)? {
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),*) $(-> $result)? {
                    $body($($arg),*)
                }
                // SAFETY: the processor has just been found to have AVX2, the only feature that the function needs.
                return unsafe { with_avx2($($arg),*) };
            }
            $body($($arg),*)
        }
    };
}

pub(crate) use dispatched;

/// Makes a function that runs a kernel, generic over [`Wide`](super::wide::Wide), with the registers that the processor has.
macro_rules! in_lanes {
    ($(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $(#[$doc])*
        $vis fn $name($($arg: $type),*) $(-> $result)? {
            use $body as body;
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),*) $(-> $result)? {
                    body::<$crate::solve::wide::avx2::Avx2>($($arg),*)
                }
                // SAFETY: the processor has just been found to have AVX2, the only feature that the function needs.
                return unsafe { with_avx2($($arg),*) };
            }
            body::<$crate::solve::wide::Plain>($($arg),*)
        }
    };
}

pub(crate) use in_lanes;
