//! hdrm
