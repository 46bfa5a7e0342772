//! What a study is about: a scene, and every technique at the settings worth trying.

use serde::{Deserialize, Serialize};

use super::{StudyError, key};
use crate::scene::file::{Override, SceneError, SceneFile};
use crate::scene::{Scene, TechniqueParams};
use crate::technique::{KNOBS, Knob, NAMES};

/// Most settings of a technique that are tried as all combinations of its knobs.
const MAX_PRODUCT: usize = 24;

/// A key of the scene file and its value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    /// As in `technique.ray_march.step`.
    pub key: String,
    /// As after `--set KEY=`.
    pub value: String,
}

/// A technique with a value for each of its knobs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Configuration {
    /// The technique's name.
    pub technique: String,
    /// Values of its knobs.
    pub settings: Vec<Setting>,
}

/// A configuration as parameters of a scene.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What was set.
    pub configuration: Configuration,
    params: TechniqueParams,
    samples_per_axis: u32,
}

/// A scene with everything that is to be tried in it.
#[derive(Clone, Debug)]
pub struct Subject {
    /// How the scene is called in reports.
    pub name: String,
    /// The scene, resolved.
    pub scene: Scene,
    /// Hash of the voxels.
    pub voxels_hash: String,
    /// What is tried.
    pub variants: Vec<Variant>,
}

impl Configuration {
    /// The settings as options of `render`: `--technique ray_march --set ...`.
    #[must_use]
    pub fn options(&self) -> String {
        let sets = self.settings.iter();
        let sets = sets.map(|s| format!(" --set {}={}", s.key, s.value));
        format!("--technique {}{}", self.technique, sets.collect::<String>())
    }

    /// For people, keys without their table: `step=1 samples_per_axis=2`.
    #[must_use]
    pub fn label(&self) -> String {
        let short = |s: &Setting| {
            let key = s.key.rsplit('.').next().unwrap_or(&s.key);
            format!("{key}={}", s.value)
        };
        self.settings
            .iter()
            .map(short)
            .collect::<Vec<_>>()
            .join(" ")
    }
}

impl Variant {
    /// `scene` with the technique and its settings, all else being equal.
    #[must_use]
    pub fn apply(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.technique = self.params.clone();
        scene.image.samples_per_axis = self.samples_per_axis;
        scene
    }
}

impl Subject {
    /// Resolves a scene and checks every setting of the `techniques` (all of them, if none is named).
    ///
    /// `file` reads the scene with further overrides. Knobs whose keys are `fixed` stay as they are.
    ///
    /// # Errors
    /// The scene cannot be read, a technique does not exist, or a setting is refused.
    pub fn new(
        name: String,
        scene: Scene,
        techniques: &[String],
        fixed: &[String],
        file: &dyn Fn(&[Override]) -> Result<SceneFile, SceneError>,
    ) -> Result<Self, StudyError> {
        let mut variants = Vec::new();
        for technique in chosen(techniques)? {
            let name = Override::parse(&format!("technique.name={technique}"))?;
            let params = file(std::slice::from_ref(&name))?.technique();
            let knobs = KNOBS.iter().find(|k| k.technique == technique);
            let mut knobs = knobs.map_or_else(Vec::new, |k| k.knobs.to_vec());
            knobs.retain(|k| (k.applies)(&params) && !fixed.iter().any(|key| key == k.key));
            for settings in expand(&knobs) {
                let mut overrides = vec![name.clone()];
                for s in &settings {
                    overrides.push(Override::parse(&format!("{}={}", s.key, s.value))?);
                }
                let file = file(&overrides)?;
                variants.push(Variant {
                    configuration: Configuration {
                        technique: technique.to_owned(),
                        settings,
                    },
                    params: file.technique(),
                    samples_per_axis: file.image().samples_per_axis,
                });
            }
        }
        Ok(Self {
            name,
            voxels_hash: key::of_volume(&scene.volume),
            scene,
            variants,
        })
    }
}

impl Subject {
    /// Hash of what is seen: the scene without its technique.
    #[must_use]
    pub fn scene_hash(&self) -> String {
        key::of_scene(&self.scene, &self.voxels_hash)
    }
}

/// The techniques asked for, in the order of the table.
fn chosen(techniques: &[String]) -> Result<Vec<&'static str>, StudyError> {
    if let Some(unknown) = techniques.iter().find(|t| !NAMES.contains(&t.as_str())) {
        return Err(StudyError::Technique {
            found: unknown.clone(),
            expected: NAMES.join(", "),
        });
    }
    let wanted = |name: &&&str| techniques.is_empty() || techniques.iter().any(|t| t == **name);
    Ok(NAMES.iter().filter(wanted).copied().collect())
}

/// The settings that a technique's knobs are tried at, coarse to fine.
///
/// All combinations where they are few. Else all knobs together from coarse to fine, and each knob alone
/// with the others at their finest.
#[must_use]
pub fn expand(knobs: &[Knob]) -> Vec<Vec<Setting>> {
    let combinations: usize = knobs.iter().map(|k| k.values.len()).product();
    let indices = if combinations <= MAX_PRODUCT {
        product(knobs)
    } else {
        diagonal_and_axes(knobs)
    };
    let setting = |(knob, i): (&Knob, &usize)| Setting {
        key: knob.key.to_owned(),
        value: knob.values[*i].to_owned(),
    };
    let settings = |list: Vec<usize>| knobs.iter().zip(&list).map(setting).collect();
    indices.into_iter().map(settings).collect()
}

fn product(knobs: &[Knob]) -> Vec<Vec<usize>> {
    let mut lists = vec![Vec::new()];
    for knob in knobs {
        let longer = |list: &Vec<usize>| {
            let list = list.clone();
            (0..knob.values.len()).map(move |i| [list.as_slice(), &[i]].concat())
        };
        lists = lists.iter().flat_map(longer).collect();
    }
    lists
}

fn diagonal_and_axes(knobs: &[Knob]) -> Vec<Vec<usize>> {
    let last = |k: &Knob| k.values.len().saturating_sub(1);
    let finest: Vec<usize> = knobs.iter().map(last).collect();
    let longest = finest.iter().copied().max().unwrap_or(0);
    let mut lists = Vec::new();
    for step in 0..=longest {
        // Knobs with fewer values reach their finest at the same time.
        let at = |last: &usize| step * last / longest.max(1);
        lists.push(finest.iter().map(at).collect());
    }
    for (i, &end) in finest.iter().enumerate() {
        for value in 0..end {
            let mut list = finest.clone();
            list[i] = value;
            if !lists.contains(&list) {
                lists.push(list);
            }
        }
    }
    lists
}
