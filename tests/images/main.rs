//! Picture files in and out, pyramids made of them, and the figures and pages that are made of pictures.

mod environment;
mod formats;
mod hostile;
mod inputs;
mod made;
mod metrics;
mod pyramid_moments;
mod pyramid_openimageio;
mod report_html;
mod shared_data;
