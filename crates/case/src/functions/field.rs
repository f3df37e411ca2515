//! Fields that functions make, such as `mag(U)`, `vorticity`, `UMean`: what they are called, what
//! they hold, and how they are written into time directories and read back.

use crate::boundary::of_kind;
use crate::fields::Sheet;
use granflow_base::{Dims, Tensor, Value as _, Vec3};
use granflow_dict::{Dict, Header, Payload, Tok, Token, Writer};
use granflow_mesh::{Mesh, PatchKind, PolyMesh};
use granflow_par::Exec;
use std::sync::Arc;

/// Components of a value of any rank, the first ones used.
pub type Components = [f64; 9];

/// What a field holds at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// One number.
    Scalar,
    /// `x y z`.
    Vector,
    /// `xx xy xz yy yz zz`.
    SymmTensor,
    /// Nine numbers by rows.
    Tensor,
}

impl Rank {
    /// Number of components.
    pub fn n(self) -> usize {
        match self {
            Rank::Scalar => 1,
            Rank::Vector => 3,
            Rank::SymmTensor => 6,
            Rank::Tensor => 9,
        }
    }
    /// OpenFOAM's word for it in the `class` of a file.
    fn class(self) -> &'static str {
        match self {
            Rank::Scalar => "volScalarField",
            Rank::Vector => "volVectorField",
            Rank::SymmTensor => "volSymmTensorField",
            Rank::Tensor => "volTensorField",
        }
    }
    /// Names of the components behind the name of the field.
    pub(super) fn suffixes(self) -> &'static [&'static str] {
        match self {
            Rank::Scalar => &[""],
            Rank::Vector => &["_x", "_y", "_z"],
            Rank::SymmTensor => &["_xx", "_xy", "_xz", "_yy", "_yz", "_zz"],
            Rank::Tensor => &["_xx", "_xy", "_xz", "_yx", "_yy", "_yz", "_zx", "_zy", "_zz"],
        }
    }
}

/// Dimensions of a field. Those of the pressure are known when its file has been read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// What does not depend on it.
    pub base: Dims,
    /// Power of the pressure's dimensions.
    pub pressure: i8,
}

impl Unit {
    /// The dimensions `base`.
    pub const fn of(base: Dims) -> Unit {
        Unit { base, pressure: 0 }
    }
    /// Those of the case's pressure.
    pub const PRESSURE: Unit = Unit { base: Dims::NONE, pressure: 1 };

    /// The product of two.
    pub const fn times(self, o: Unit) -> Unit {
        Unit { base: self.base.mul(o.base), pressure: self.pressure + o.pressure }
    }
    /// Over a length.
    pub const fn per_length(self) -> Unit {
        Unit { base: self.base.div(Dims::LENGTH), ..self }
    }
    /// The dimensions, with the pressure's.
    pub fn dims(self, pressure: Dims) -> Dims {
        (0..self.pressure).fold(self.base, |d, _| d.mul(pressure))
    }
}

/// What a function makes.
#[derive(Clone, Debug, PartialEq)]
pub struct Info {
    /// Name, and that of its file.
    pub name: String,
    /// What it holds.
    pub rank: Rank,
    /// Its dimensions.
    pub unit: Unit,
    /// Whether boundary faces have values of their own, rather than those of their cells.
    pub on_faces: bool,
}

/// The values of a field on one rank's mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// Number of components.
    pub n: usize,
    /// Of own cells and ghosts, component by component.
    pub cells: Vec<f64>,
    /// Of boundary faces; empty where those have the values of their cells.
    pub faces: Vec<f64>,
}

impl Values {
    /// Zero everywhere.
    pub fn new(mesh: &Mesh, info: &Info) -> Values {
        let n = info.rank.n();
        let faces = if info.on_faces { mesh.n_faces() - mesh.n_inner } else { 0 };
        Values { n, cells: vec![0.0; n * mesh.n_all()], faces: vec![0.0; n * faces] }
    }
    /// The value in cell `c`.
    pub fn cell(&self, c: usize) -> Components {
        components(&self.cells[self.n * c..self.n * (c + 1)])
    }
    /// The value on boundary face `f`, if it has one of its own.
    pub fn face(&self, mesh: &Mesh, f: usize) -> Option<Components> {
        let i = f - mesh.n_inner;
        Some(components(self.faces.get(self.n * i..self.n * (i + 1))?))
    }
    /// Sets the value in cell `c`.
    pub fn set_cell(&mut self, c: usize, v: &Components) {
        self.cells[self.n * c..self.n * (c + 1)].copy_from_slice(&v[..self.n]);
    }
    /// Sets the value on boundary face `f`.
    pub fn set_face(&mut self, mesh: &Mesh, f: usize, v: &Components) {
        let i = f - mesh.n_inner;
        self.faces[self.n * i..self.n * (i + 1)].copy_from_slice(&v[..self.n]);
    }
    /// Brings ghosts up to date. Every rank calls it.
    pub fn update_ghosts(&mut self, exec: &Exec, mesh: &Mesh) {
        match self.n {
            1 => mesh.halo.update(exec, &mut self.cells),
            3 => mesh.halo.update::<Vec3>(exec, self.cells.as_chunks_mut::<3>().0),
            6 => {
                let whole = |s: &[f64; 6]| [s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]];
                let mut all: Vec<Tensor> =
                    self.cells.as_chunks::<6>().0.iter().map(whole).collect();
                mesh.halo.update(exec, &mut all);
                for (s, t) in self.cells.as_chunks_mut::<6>().0.iter_mut().zip(all) {
                    *s = [t[0], t[1], t[2], t[4], t[5], t[8]];
                }
            }
            _ => mesh.halo.update::<Tensor>(exec, self.cells.as_chunks_mut::<9>().0),
        }
    }
}

/// Values as components.
pub(super) fn components(v: &[f64]) -> Components {
    let mut out = [0.0; 9];
    out[..v.len()].copy_from_slice(v);
    out
}

/// A field of the whole mesh in the user's numbering.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Whole {
    /// In cells, component by component.
    pub cells: Vec<f64>,
    /// On all faces of the mesh, of which only those of the boundary count; empty as in [`Values`].
    pub faces: Vec<f64>,
}

/// The text of the field's file.
pub(crate) fn file(info: &Info, dims: Dims, whole: &Whole, sheet: &Sheet<'_>) -> Vec<u8> {
    let n = info.rank.n();
    let header =
        Header::new(info.rank.class(), &info.name).location(sheet.time).format(sheet.format);
    let mut w = Writer::new(&header);
    w.dims("dimensions", dims);
    w.blank();
    put(&mut w, "internalField", info.rank, &whole.cells);
    w.blank();
    w.open("boundaryField");
    for p in &sheet.poly.patches {
        w.open(&p.name);
        let dictated = !matches!(p.kind, PatchKind::Patch | PatchKind::Wall);
        if dictated {
            w.dict(&of_kind(&p.kind));
        } else if p.len > 0 && !whole.faces.is_empty() {
            w.entry("type", "calculated");
            put(&mut w, "value", info.rank, &whole.faces[n * p.start..n * (p.start + p.len)]);
        } else {
            w.entry("type", "zeroGradient");
        }
        w.close();
    }
    w.close();
    w.finish()
}

fn put(w: &mut Writer, key: &str, rank: Rank, flat: &[f64]) {
    match rank {
        Rank::Scalar => w.field(key, flat),
        Rank::Vector => w.field(key, flat.as_chunks::<3>().0),
        Rank::Tensor => w.field(key, flat.as_chunks::<9>().0),
        Rank::SymmTensor => {
            let all = flat.as_chunks::<6>().0;
            let mut d = Dict::new();
            let value = match all.first() {
                Some(v) if all.iter().all(|x| x == v) => {
                    let parts = v.iter().map(|x| Token::of_number(*x)).collect();
                    vec![Token::of_word("uniform"), Token::of_list(parts)]
                }
                _ => {
                    let list = Payload::SymmTensors(all.to_vec());
                    let list = Token::generated(Tok::Packed(Arc::new(list)));
                    vec![Token::of_word("nonuniform"), list]
                }
            };
            d.set(key, value);
            w.dict(&d);
        }
    }
}

/// The field `info` of a file that was read; `None` when it holds something else.
pub(crate) fn parse(info: &Info, dict: &Dict, poly: &PolyMesh) -> Option<Whole> {
    let n = info.rank.n();
    let cells = flat(dict.stream("internalField")?, poly.n_cells(), n)?;
    let mut faces = Vec::new();
    if info.on_faces {
        faces.resize(n * poly.n_faces(), 0.0);
        let boundary = dict.sub("boundaryField")?;
        let own = |p: &&granflow_mesh::PolyPatch| {
            matches!(p.kind, PatchKind::Patch | PatchKind::Wall) && p.len > 0
        };
        for p in poly.patches.iter().filter(own) {
            let values = flat(boundary.sub(&p.name)?.stream("value")?, p.len, n)?;
            faces[n * p.start..n * (p.start + p.len)].copy_from_slice(&values);
        }
    }
    Some(Whole { cells, faces })
}

/// `uniform v` or `nonuniform List<..> ..` of `count` values with `n` components each.
pub(crate) fn flat(tokens: &[Token], count: usize, n: usize) -> Option<Vec<f64>> {
    let value = tokens.last()?;
    if tokens.first()?.word() == Some("uniform") {
        let one = if n == 1 { vec![value.number()?] } else { value.scalars()? };
        return (one.len() == n).then(|| one.repeat(count));
    }
    let all: Vec<f64> = match &value.kind {
        Tok::Packed(p) => match &**p {
            Payload::Scalars(x) => x.clone(),
            Payload::Labels(x) => x.iter().map(|i| *i as f64).collect(),
            Payload::Vectors(x) => x.as_flattened().to_vec(),
            Payload::SymmTensors(x) => x.as_flattened().to_vec(),
            Payload::Tensors(x) => x.as_flattened().to_vec(),
            _ => return None,
        },
        _ => {
            let parts = value.list()?.iter();
            let parts = parts.map(|t| if n == 1 { Some(vec![t.number()?]) } else { t.scalars() });
            parts.collect::<Option<Vec<_>>>()?.concat()
        }
    };
    (all.len() == n * count && all.iter().all(|x| x.is_finite())).then_some(all)
}

/// `Q` and the like of a velocity gradient `G_ij = d_i U_j`.
pub(super) fn double_dot_transposed(g: &Tensor) -> f64 {
    let turned = [g[0], g[3], g[6], g[1], g[4], g[7], g[2], g[5], g[8]];
    g.inner(turned)
}
