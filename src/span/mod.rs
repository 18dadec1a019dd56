//! Constraints and analyses that span many bodies at once (Müller et al. 2017).

pub(crate) mod support;
