//! JSON Schemas of every kind of file that a person writes.

use crate::args::SchemaOf;
use retune::objective::{RESIDUALS, Residual};
use serde_json::{Value, json};

/// Every kind, with the name of its schema file.
pub(crate) const ALL: [(SchemaOf, &str); 6] = [
    (SchemaOf::Model, "model.schema.json"),
    (SchemaOf::Test, "test.schema.json"),
    (SchemaOf::Objective, "objective.schema.json"),
    (SchemaOf::Profiles, "profiles.schema.json"),
    (SchemaOf::Optimizer, "optimizer.schema.json"),
    (SchemaOf::Patch, "patch.schema.json"),
];

/// The schema of a kind of file.
pub(crate) fn schema(of: SchemaOf) -> Value {
    match of {
        SchemaOf::Model => retune::model::schema(),
        SchemaOf::Test => retune::data::schema(),
        SchemaOf::Optimizer => retune::optim::schema(),
        SchemaOf::Objective => objective(),
        SchemaOf::Profiles => profiles(),
        SchemaOf::Patch => patch(),
    }
}

const DRAFT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Patches, as `ModelSpec::overlaid` merges them: the keys of a model, none of them required, since each may stand in the model already.
fn patch() -> Value {
    fn without_required(value: &mut Value) {
        match value {
            Value::Object(map) => {
                // A property may be called `required`; the keyword is a list.
                if map.get("required").is_some_and(Value::is_array) {
                    map.shift_remove("required");
                }
                map.values_mut().for_each(without_required);
            }
            Value::Array(list) => list.iter_mut().for_each(without_required),
            _ => {}
        }
    }
    let mut schema = retune::model::schema();
    without_required(&mut schema);
    schema["title"] = json!("Patch");
    schema["description"] = json!("A partial model file that is laid over a model.");
    schema
}

/// One number under one word: `{huber: 2}`.
fn choice(word: &str, text: &str) -> Value {
    json!({
        "type": "object",
        "description": text,
        "properties": { word: { "type": "number", "exclusiveMinimum": 0 } },
        "required": [word],
        "additionalProperties": false
    })
}

/// Objective files, as `ObjectiveSpec` reads them.
fn objective() -> Value {
    let terms: serde_json::Map<String, Value> = RESIDUALS
        .iter()
        .map(|r| {
            (Residual::name(*r).to_string(), json!({ "type": "number", "minimum": 0, "description": r.summary() }))
        })
        .collect();
    let quantity = json!({ "type": ["number", "string"] });
    json!({
        "$schema": DRAFT,
        "title": "Objective",
        "type": "object",
        "additionalProperties": false,
        "properties": {
            "terms": {
                "type": "object",
                "description": "Terms with a factor of their squared residuals; all that the test has data for when absent. Priors and targets are always there.",
                "properties": terms,
                "additionalProperties": false
            },
            "loss": {
                "description": "What a residual r costs: `squares` r²/2; `{huber: k}` linear beyond k standard deviations; `{student-t: n}` that of n degrees of freedom. Default `squares`.",
                "anyOf": [
                    { "enum": ["squares"] },
                    choice("huber", "Squares up to so many standard deviations, linear beyond."),
                    choice("student-t", "Student's t with so many degrees of freedom.")
                ]
            },
            "regularization": {
                "description": "A pull of all free parameters towards their estimates: `none`, the weight that makes the data most probable (`evidence`), that at the corner of the L-curve (`l-curve`), or `{weight: w}`. Default `none`.",
                "anyOf": [
                    { "enum": ["none", "evidence", "l-curve"] },
                    choice("weight", "Of this weight: a prior standard deviation of 1/√w of each interval.")
                ]
            },
            "limits": {
                "type": "array",
                "description": "Inequalities between parameters.",
                "items": { "$ref": "#/$defs/Limit" }
            }
        },
        "$defs": {
            "Limit": {
                "type": "object",
                "description": "An inequality: at_least <= expression <= at_most.",
                "additionalProperties": false,
                "properties": {
                    "expression": { "$ref": "#/$defs/Scalar", "description": "A sum of parameters with factors." },
                    "at_most": { "$ref": "#/$defs/Scalar", "description": "Its largest value." },
                    "at_least": { "$ref": "#/$defs/Scalar", "description": "Its smallest value." }
                },
                "required": ["expression"]
            },
            "Scalar": quantity
        }
    })
}

/// Lists of criteria profiles, as `CriteriaProfile` reads them.
fn profiles() -> Value {
    let fraction = |text: &str| json!({ "type": "number", "minimum": 0, "maximum": 1, "description": text });
    json!({
        "$schema": DRAFT,
        "title": "Profiles",
        "type": "array",
        "items": {
            "type": "object",
            "additionalProperties": false,
            "properties": {
                "name": { "type": "string", "description": "Short name, by which `--profile FILE.yaml:NAME` asks for it." },
                "source": { "type": "string", "description": "Where the marks come from." },
                "verified": { "type": "boolean", "description": "Whether the text of that source was read when the profile was written." },
                "modes": {
                    "type": "array",
                    "minItems": 1,
                    "description": "Marks by class of mode; the first class serves modes of unknown class.",
                    "items": { "$ref": "#/$defs/Marks" }
                },
                "mac_off_diagonal": fraction("Largest MAC between modes that are not a pair."),
                "cross_orthogonality_off_diagonal": fraction("Largest cross-orthogonality, by modulus, between modes that are not a pair."),
                "auto_orthogonality_off_diagonal": fraction("Largest auto-orthogonality of the test shapes off the diagonal, by modulus.")
            },
            "required": ["name", "source", "verified", "modes"]
        },
        "$defs": {
            "Marks": {
                "type": "object",
                "description": "Marks for one class of modes.",
                "additionalProperties": false,
                "properties": {
                    "class": { "type": "string", "description": "The class: `primary`, `fundamental`, `all`, ..." },
                    "frequency_tolerance": { "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1, "description": "Largest relative error of a frequency: 0.05 for 5 %." },
                    "mac": fraction("Smallest MAC of a pair."),
                    "cross_orthogonality": fraction("Smallest modulus of the cross-orthogonality of a pair.")
                },
                "required": ["class"]
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{objective, patch, profiles};
    use retune::correlation::parse_profiles;
    use retune::update::ObjectiveSpec;
    use serde_json::Value;

    fn keys(object: &Value) -> Vec<String> {
        object["properties"].as_object().unwrap().keys().map(|k| format!("`{k}`")).collect()
    }

    /// What the reader of the file says that it knows.
    #[test]
    fn schemas_written_by_hand_have_the_keys_that_are_read() {
        let said = |text: &str| ObjectiveSpec::read(text).unwrap_err()[0].message.clone();
        let message = said("xyz: 1");
        assert!(message.contains(&keys(&objective()).join(", ")), "{message}");
        let message = said("limits: [{xyz: 1}]");
        assert!(message.contains(&keys(&objective()["$defs"]["Limit"]).join(", ")), "{message}");
        let said = |text: &str| parse_profiles(text).unwrap_err().to_string();
        let message = said("[{xyz: 1}]");
        assert!(message.contains(&keys(&profiles()["items"]).join(", ")), "{message}");
        let message = said("[{name: a, source: b, verified: true, modes: [{xyz: 1}]}]");
        assert!(message.contains(&keys(&profiles()["$defs"]["Marks"]).join(", ")), "{message}");
    }

    #[test]
    fn a_patch_has_the_keys_of_a_model_and_requires_none() {
        let (model, patch) = (retune::model::schema(), patch());
        assert_eq!(keys(&model), keys(&patch));
        assert!(model.to_string().contains("\"required\":[") && !patch.to_string().contains("\"required\":["));
    }

    #[test]
    fn choices_of_the_schema_are_read() {
        for text in [
            "loss: squares",
            "loss: {huber: 2}",
            "loss: {student-t: 4}",
            "regularization: none",
            "regularization: evidence",
            "regularization: l-curve",
            "regularization: {weight: 0.1}",
            "terms: {frequency: 1, mac: 0}",
            "limits: [{expression: a + 2*b, at_most: 3 kg}]",
        ] {
            assert!(ObjectiveSpec::read(text).is_ok(), "{text}");
        }
    }
}
