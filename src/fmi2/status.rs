//! Status of an FMI call (`fmi2Status`).

/// Status of an FMI call, with the numbers of C.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(i32)]
pub enum CallStatus {
    /// Success.
    Ok = 0,
    /// Success with a remark in the log.
    Warning = 1,
    /// No success; the instance stays valid.
    Discard = 2,
    /// Refused call; the instance is unchanged.
    Error = 3,
    /// Lost instance.
    Fatal = 4,
}
