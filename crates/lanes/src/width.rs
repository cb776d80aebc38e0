//! How many lanes to use.

use std::fmt;
use std::sync::OnceLock;

/// A number of lanes. Every width works on every machine, with the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Width {
    /// Scalar.
    X1,
    /// SSE2, NEON, simd128.
    X4,
    /// AVX2.
    X8,
    /// AVX-512F.
    X16,
}

impl Width {
    /// All widths, narrowest first.
    pub const ALL: [Self; 4] = [Self::X1, Self::X4, Self::X8, Self::X16];

    /// The number of lanes.
    pub const fn lanes(self) -> usize {
        match self {
            Self::X1 => 1,
            Self::X4 => 4,
            Self::X8 => 8,
            Self::X16 => 16,
        }
    }

    /// The width with so many lanes.
    pub fn from_lanes(lanes: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|width| width.lanes() == lanes)
    }

    /// The widest that this machine has instructions for.
    pub fn native() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use crate::x86::{has_avx2, has_avx512};
            match () {
                _ if has_avx512() => Self::X16,
                _ if has_avx2() => Self::X8,
                _ => Self::X4,
            }
        }
        #[cfg(any(target_arch = "aarch64", all(target_arch = "wasm32", target_feature = "simd128")))]
        {
            Self::X4
        }
        #[cfg(not(any(
            target_arch = "x86_64",
            target_arch = "aarch64",
            all(target_arch = "wasm32", target_feature = "simd128")
        )))]
        {
            Self::X1
        }
    }

    /// What the environment variable `JOUNCE_LANES` asks for (1, 4, 8 or 16), else [`native`](Self::native). Looked up
    /// once per process. Another value is as good as none: the variable is for tests and measurements, and no width
    /// changes a result.
    pub fn detect() -> Self {
        static FOUND: OnceLock<Width> = OnceLock::new();
        *FOUND.get_or_init(|| {
            let asked = std::env::var("JOUNCE_LANES").ok();
            asked.and_then(|lanes| Self::from_lanes(lanes.trim().parse().ok()?)).unwrap_or_else(Self::native)
        })
    }
}

impl fmt::Display for Width {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.lanes().fmt(out)
    }
}
