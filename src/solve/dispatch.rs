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

/// Makes a function that runs a kernel, generic over the registers that it computes in, with those that the processor has: the
/// first of two types where it has AVX2, else the second.
macro_rules! in_registers {
    (
        $(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($avx2:ty, $plain:ty), ($($arg:ident: $type:ty),*) $(-> $result:ty)?
    ) => {
        $(#[$doc])*
        $vis fn $name($($arg: $type),*) $(-> $result)? {
            use $body as body;
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($arg: $type),*) $(-> $result)? {
                    body::<$avx2>($($arg),*)
                }
                // SAFETY: the processor has just been found to have AVX2, the only feature that the function needs.
                return unsafe { with_avx2($($arg),*) };
            }
            body::<$plain>($($arg),*)
        }
    };
}

pub(crate) use in_registers;

/// As [`in_registers`], of a kernel that is generic over [`Wide`](super::wide::Wide).
macro_rules! in_lanes {
    ($(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $crate::solve::dispatch::in_registers!(
            $(#[$doc])* $vis $name, $body, ($crate::solve::wide::avx2::Avx2, $crate::solve::wide::Plain),
            ($($arg: $type),*) $(-> $result)?
        );
    };
}

pub(crate) use in_lanes;
