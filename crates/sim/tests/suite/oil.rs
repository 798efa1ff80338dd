//! Tables of oils, shared by machines.

use hydrocrane_physics::hydraulics::fluid::{ElasticEnergy, Fluid, OilTables};
use hydrocrane_plant::oil::{tables, MOST};
use std::sync::Arc;

#[test]
fn every_oil_has_its_own_tables_and_few_are_kept() {
    let oil =
        |c2: f64| Fluid { density: 1000.0, bulk_max: 1e9, rise: 4.5e-6, c2, vacuum: -1e5, ignore_cavitation: false };
    let first = tables(&oil(3.0));
    assert!(Arc::ptr_eq(&first, &tables(&oil(3.0))));
    let mut others = Vec::new();
    for i in 0..2 * MOST {
        let other = oil(3.0 + 0.01 * (i + 1) as f64);
        let (own, afresh) = (tables(&other), OilTables::new(other));
        assert_eq!(own.energy_density(1e7), afresh.energy_density(1e7));
        assert_ne!(own.energy_density(1e7), first.energy_density(1e7));
        others.push(Arc::downgrade(&own));
        // What is asked for again and again stays.
        assert!(Arc::ptr_eq(&first, &tables(&oil(3.0))));
    }
    let kept = others.iter().filter(|other| other.strong_count() > 0).count();
    assert!(kept < MOST, "{kept} of {} are kept", others.len());
}
