//! What `--time` says: a step, several, or how long `path_trace` renders.

use std::ops::RangeInclusive;

use super::CliError;

/// The value of `--time`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Time {
    /// One time step.
    Step(u32),
    /// Several.
    Steps(Steps),
    /// A duration.
    Seconds(f64),
}

/// Time steps to be rendered one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Steps {
    /// From the first to the last, both included.
    Range(u32, u32),
    /// Every step there is.
    All,
}

impl Steps {
    /// The steps of a volume of `count`; those beyond its end stay in, for the scene to refuse.
    pub(super) fn of(self, count: u32) -> RangeInclusive<u32> {
        match self {
            Self::Range(first, last) => first..=last,
            Self::All => 0..=count.saturating_sub(1),
        }
    }
}

/// Parses `--time`.
pub(super) fn time(text: &str) -> Result<Time, String> {
    if let Ok(step) = text.parse() {
        return Ok(Time::Step(step));
    }
    if text == "all" {
        return Ok(Time::Steps(Steps::All));
    }
    if let Some((first, last)) = text.split_once("..") {
        let steps = (first.trim().parse(), last.trim().parse());
        return match steps {
            (Ok(first), Ok(last)) if first <= last => Ok(Time::Steps(Steps::Range(first, last))),
            _ => {
                Err("expected FIRST..LAST, both included, FIRST not above LAST, as 0..9".to_owned())
            }
        };
    }
    duration(text).map(Time::Seconds).map_err(|_| {
        "expected a time step (a whole number), steps as 0..9, `all`, or a duration as 500ms, 30s, 5m, 1h"
            .to_owned()
    })
}

/// A duration as 500ms, 30s, 5m, 1h, in seconds.
pub(super) fn duration(text: &str) -> Result<f64, String> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let in_unit = |(unit, seconds): (&str, f64)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        (number > 0.0 && number.is_finite()).then_some(number * seconds)
    };
    let found = units.into_iter().find_map(in_unit);
    found.ok_or_else(|| "expected a duration as 500ms, 30s, 5m, 1h".to_owned())
}

/// Refuses several steps where a command shows one.
pub(super) fn one_step(time: Option<Time>) -> Result<(), CliError> {
    match time {
        Some(Time::Steps(_)) => Err(CliError::Usage(
            "--time FIRST..LAST and --time all are for `render`; expected one time step".to_owned(),
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_told_apart() {
        assert_eq!(time("3"), Ok(Time::Step(3)));
        assert_eq!(time("2..7"), Ok(Time::Steps(Steps::Range(2, 7))));
        assert_eq!(time("all"), Ok(Time::Steps(Steps::All)));
        assert_eq!(time("500ms"), Ok(Time::Seconds(0.5)));
        for wrong in [
            "7..2",
            "..3",
            "3..",
            "1..=2",
            "a..b",
            "-1",
            "soon",
            "3 s s",
            "1..99999999999",
        ] {
            assert!(time(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn all_is_every_step() {
        assert_eq!(Steps::All.of(5), 0..=4);
        assert_eq!(Steps::Range(2, 9).of(5), 2..=9);
    }
}
