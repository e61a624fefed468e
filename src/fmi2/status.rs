//! What a call came to, in the numbers of C.

/// What a call came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, with a remark in the log.
    Warning = 1,
    /// Not done; the instance is still good.
    Discard = 2,
    /// Refused; nothing was changed.
    Error = 3,
    /// The instance is lost.
    Fatal = 4,
}
