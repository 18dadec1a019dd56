//! Kernel entry on targets whose vector registers are known at compile time: nothing to choose at run time.

/// Makes a function that runs its body.
macro_rules! dispatched {
    ($(#[$doc:meta])* $name:ident, $body:ident, ($($arg:ident: $type:ty),*) $(-> $result:ty)?) => {
        $(#[$doc])*
        pub(crate) fn $name($($arg: $type),*) $(-> $result)? {
            $body($($arg),*)
        }
    };
}

pub(crate) use dispatched;

/// Makes a function that runs a kernel with the first of two kinds of registers.
macro_rules! in_registers {
    (
        $(#[$doc:meta])* $vis:vis $name:ident, $body:path, ($own:ty, $baseline:ty), ($($arg:ident: $type:ty),*) $(-> $result:ty)?
    ) => {
        $(#[$doc])*
        $vis fn $name($($arg: $type),*) $(-> $result)? {
            use $body as body;
            // The second kernel is compiled for tests alone.
            #[cfg(test)]
            if $crate::platform::holds_to_baseline() {
                return body::<$baseline>($($arg),*);
            }
            body::<$own>($($arg),*)
        }
    };
}

pub(crate) use in_registers;
