//! Energy balances of actuators and supply as text, CSV and JSON, for `energy` and the report.

use std::io;

use cosim::io::cells::cell as quoted;
use serde_json::{Value, json};

use crate::measures::energy::{Balance, Energies};
use crate::measures::supply::Supply;

/// The balances of the actuators as a table, one column each.
pub fn text(title: &str, balances: &[Balance]) -> String {
    let mut text = format!("{title}\n{:<34}", "energy over the motion, J");
    for b in balances {
        text += &format!("{:>12}", b.actuator);
    }
    text += "\n";
    for (name, get) in ROWS {
        text += &format!("{name:<34}");
        for b in balances {
            let value = get(b).map_or("-".into(), |value| format!("{value:.2}"));
            text += &format!("{value:>12}");
        }
        text += "\n";
    }
    text
}

type Quantity = (&'static str, fn(&Balance) -> Option<f64>);
/// Rows of the table and columns of the CSV file.
const ROWS: [Quantity; 13] = [
    ("electrical, taken", |b| Some(b.electrical)),
    ("electrical, given back", |b| Some(b.regenerated)),
    ("work on the load", |b| Some(b.work)),
    ("work by the load", |b| Some(b.returned)),
    ("work by the coupling at the rod", |b| Some(b.shift)),
    ("loss, copper", |b| Some(b.copper)),
    ("loss, iron", |b| Some(b.core)),
    ("loss, inverter", |b| Some(b.inverter)),
    ("loss, mechanical", |b| Some(b.mechanical)),
    ("rise of stored energy", |b| Some(b.stored)),
    ("balance left open", |b| Some(b.residual())),
    ("efficiency while work is done, %", |b| {
        b.efficiency().map(|e| 100.0 * e)
    }),
    ("throughput (out / in), %", |b| Some(100.0 * b.throughput())),
];

/// A row for each actuator of each case, energies in J.
pub fn write_csv(cases: &[(String, Energies)], to: &mut impl io::Write) -> io::Result<()> {
    let heads: Vec<_> = ROWS.iter().map(|(name, _)| quoted(name)).collect();
    writeln!(to, "trajectory,actuator,{}", heads.join(","))?;
    for (case, energies) in cases {
        for b in &energies.balances {
            let cell = |(_, get): &Quantity| get(b).map_or(String::new(), |v| v.to_string());
            let cells: Vec<_> = ROWS.iter().map(cell).collect();
            let (case, actuator) = (quoted(case), quoted(&b.actuator));
            writeln!(to, "{case},{actuator},{}", cells.join(","))?;
        }
    }
    Ok(())
}

/// The balance of the component that feeds the drives, as text.
pub fn supply_text(supply: &Supply) -> String {
    let mut text = format!("energy over the whole run, J: {}\n", supply.component);
    let mut line = |name: &str, value: f64| {
        text += &format!("{name:<46}{value:>14.4}\n");
    };
    if let Some(s) = supply.source {
        line("from the source of the pack", s.battery);
        line("  burnt in the brake resistor", s.brake);
        line("  lost in pack, wiring and limit", s.lost);
        line("  rise of stored energy in the link", s.stored);
    }
    line("given to the drives", supply.given);
    line("  lost by the coupling at the bonds", supply.residual);
    line("  work on the load, less work by it", supply.work);
    line("  work by the coupling at the rods", supply.shift);
    line("  lost in the drives", supply.lost);
    line("  rise of stored energy in the drives", supply.stored);
    line("left open", supply.open());
    let both = "went through the bonds in either direction";
    line(both, supply.throughput);
    for range in &supply.ranges {
        let name = format!("{}, {}: least, greatest, last", range.name, range.unit);
        let values = [range.least, range.greatest, range.last].map(|v| format!("{v:>14.4}"));
        text += &format!("{name:<46}{}\n", values.concat());
    }
    text
}

/// A balance with its derived values, for programs.
pub fn balance_json(balance: &Balance) -> Value {
    let mut value = json!(balance);
    value["efficiency"] = balance.efficiency().into();
    value["throughput"] = balance.throughput().into();
    value["residual"] = balance.residual().into();
    value
}
