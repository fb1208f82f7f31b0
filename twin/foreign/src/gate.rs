//! The gate of a predictor beside a recorded flight, in words: where it is better than persistence and than the mean.

use super::shadow_score::HorizonReport;

/// Where the forecasts of `prediction` are better than both baselines, and where they are not.
pub fn sentence(prediction: &[HorizonReport]) -> String {
    let steps = |of: fn(&HorizonReport) -> Option<bool>, wanted: bool| {
        let fit = prediction.iter().filter(|horizon| of(horizon) == Some(wanted));
        fit.map(|horizon| horizon.j.to_string()).collect::<Vec<_>>().join(", ")
    };
    let both = |horizon: &HorizonReport| {
        Some(horizon.better_than_persistence? && horizon.better_than_mean?)
    };
    let (good, behind, vague) = (
        steps(both, true),
        steps(|horizon| horizon.better_than_persistence, false),
        steps(|horizon| horizon.better_than_mean, false),
    );
    if prediction.iter().all(|horizon| both(horizon).is_none()) {
        return "no forecast was scored: no residual was known in the air".to_owned();
    }
    let mut parts = Vec::new();
    if !good.is_empty() {
        parts.push(format!("better than persistence and than the mean at j = {good}"));
    }
    if !behind.is_empty() {
        parts.push(format!("not better than persistence at j = {behind}"));
    }
    if !vague.is_empty() {
        parts.push(format!("not better than the mean at j = {vague}"));
    }
    parts.join("; ")
}

/// Whether the forecasts are better than both baselines at every step; `None` without a score.
pub fn is_passed(prediction: &[HorizonReport]) -> Option<bool> {
    let better = |horizon: &HorizonReport| {
        Some(horizon.better_than_persistence? && horizon.better_than_mean?)
    };
    prediction.iter().filter_map(better).reduce(|all, one| all && one)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(j: usize, persistence: f64, mean: f64) -> HorizonReport {
        HorizonReport {
            j,
            rmse_z: Some(1.0),
            persistence_rmse_z: Some(persistence),
            mean_rmse_z: Some(mean),
            better_than_persistence: Some(1.0 < persistence),
            better_than_mean: Some(1.0 < mean),
            band_90_holds: None,
            band_90_z: None,
            samples: 1,
        }
    }

    #[test]
    fn each_step_stands_behind_what_it_is_better_or_not_better_than() {
        let all = [at(0, 2.0, 2.0), at(3, 2.0, 2.0)];
        assert_eq!(is_passed(&all), Some(true));
        assert_eq!(sentence(&all), "better than persistence and than the mean at j = 0, 3");
        let mixed = [at(0, 2.0, 2.0), at(3, 0.9, 2.0), at(20, 0.9, 0.9)];
        assert_eq!(
            sentence(&mixed),
            "better than persistence and than the mean at j = 0; not better than persistence at j = 3, 20; not better than the mean at j = 20"
        );
        assert_eq!(is_passed(&mixed), Some(false));
        assert_eq!(sentence(&[at(6, 0.5, 2.0)]), "not better than persistence at j = 6");
    }

    #[test]
    fn a_flight_without_a_score_claims_nothing() {
        let unknown = HorizonReport {
            rmse_z: None,
            better_than_persistence: None,
            better_than_mean: None,
            ..at(0, 1.0, 1.0)
        };
        assert_eq!(is_passed(std::slice::from_ref(&unknown)), None);
        assert!(sentence(&[unknown]).starts_with("no forecast was scored"));
    }
}
